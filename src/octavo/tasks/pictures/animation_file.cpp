#include "octavo/tasks/pictures/animation_file.h"

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

namespace {

/// Errors are of the name that the file is to have.
template <class F>
void named_as(const PendingFile& file, F&& f) {
  try {
    f();
  } catch (const Error& error) {
    throw error.with_path(file.path());
  }
}

}  // namespace

bool is_animation(const std::string& path) {
  return path.ends_with(".apng") || path.ends_with(".webp") || path.ends_with(".mp4");
}

AnimationFile::AnimationFile(const std::string& path, const AnimationFrame& frame,
                             const TaskContext& context)
    : context_(context), file_(std::make_unique<PendingFile>(local_storage(), path)) {
  if (path.ends_with(".webp")) {
    webp_ = std::make_unique<AnimatedWebp>(frame.fps);
  } else if (path.ends_with(".mp4")) {
    named_as(*file_, [&] {
      video_ = std::make_unique<VideoPipe>(file_->temporary_path(), frame.width, frame.height,
                                           frame.fps);
    });
  } else {
    png_ = std::make_unique<AnimatedPng>(frame.pictures, frame.fps);
  }
}

void AnimationFile::add(const Picture& picture) {
  if (context_.watcher().is_cancelled()) {
    throw Error(ErrorKind::cancelled, "stopped before it was complete", file_->path());
  }
  named_as(*file_, [&] {
    if (webp_) webp_->add(picture);
    else if (video_) video_->add(picture);
    else file_->append(png_->add(picture));
  });
}

void AnimationFile::publish(bool overwrite) {
  named_as(*file_, [&] {
    if (webp_) file_->append(webp_->finish());
    if (video_) video_->finish();
  });
  file_->seal();
  file_->publish(overwrite);
}

}  // namespace octavo
