#include "octavo/tasks/pictures/animation_file.h"

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

bool is_animation(const std::string& path) { return path.ends_with(".apng"); }

AnimationFile::AnimationFile(const std::string& path, std::uint32_t pictures, int fps,
                             const TaskContext& context)
    : context_(context),
      encoder_(pictures, fps),
      file_(std::make_unique<PendingFile>(local_storage(), path)) {}

void AnimationFile::add(const Picture& picture) {
  if (context_.watcher().is_cancelled()) {
    throw Error(ErrorKind::cancelled, "stopped before it was complete", file_->path());
  }
  file_->append(encoder_.add(picture));
}

void AnimationFile::publish(bool overwrite) {
  file_->seal();
  file_->publish(overwrite);
}

}  // namespace octavo
