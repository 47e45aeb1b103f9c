// PNG files that get their names together, when the last is complete.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/file/storage/pending_file.h"
#include "octavo/render/picture.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Throws Error{invalid_argument} unless `path` ends in .png.
void require_png(const std::string& path);

/// Pictures that are on disk under temporary names until all are complete.
class PictureFiles {
 public:
  explicit PictureFiles(const TaskContext& context) : context_(context) {}

  /// Throws Error{cancelled}, and what writing throws
  void add(const std::string& path, const Picture& picture);

  /// Gives all their names. Throws Error{io} where one is taken and not to be overwritten: then
  /// none of them stands there, unless it replaced an earlier one.
  void publish(bool overwrite);

 private:
  const TaskContext& context_;
  std::vector<std::unique_ptr<PendingFile>> files_;
};

}  // namespace octavo
