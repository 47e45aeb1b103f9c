// PNG files that get their names together, when the last is complete.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "octavo/file/storage/pending_file.h"
#include "octavo/render/picture.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Throws Error{invalid_argument} unless `path` ends in .png.
void require_png(const std::string& path);

/// Takes a picture in place of a file.
using PictureListener = std::function<void(const Picture&)>;

/// Pictures that are on disk under temporary names until all are complete.
class PictureFiles {
 public:
  /// on_picture  where it is set takes all pictures, and no file is written
  explicit PictureFiles(const TaskContext& context, PictureListener on_picture = {})
      : context_(context), on_picture_(std::move(on_picture)) {}

  /// Throws Error{cancelled}, and what writing throws
  void add(const std::string& path, const Picture& picture);

  /// Gives all their names. Throws Error{io} where one is taken and not to be overwritten: then
  /// none of them stands there, unless it replaced an earlier one.
  void publish(bool overwrite);

 private:
  const TaskContext& context_;
  PictureListener on_picture_;
  std::vector<std::unique_ptr<PendingFile>> files_;
};

}  // namespace octavo
