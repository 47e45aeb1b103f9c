// An animated PNG that gets its name when its last picture is in it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/file/storage/pending_file.h"
#include "octavo/render/animated_png.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Whether a name ends in .apng.
bool is_animation(const std::string& path);

class AnimationFile {
 public:
  AnimationFile(const std::string& path, std::uint32_t pictures, int fps,
                const TaskContext& context);

  /// Writes one picture. Throws as PictureFiles::add and AnimatedPng::add
  void add(const Picture& picture);

  /// Requires that all pictures were added. Throws Error{io} where the name is taken and not to be
  /// overwritten
  void publish(bool overwrite);

 private:
  const TaskContext& context_;
  AnimatedPng encoder_;
  std::unique_ptr<PendingFile> file_;
};

}  // namespace octavo
