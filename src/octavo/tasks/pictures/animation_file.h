// An animation that gets its name when its last picture is in it: PNG, WebP or MP4.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/file/storage/pending_file.h"
#include "octavo/render/animated_png.h"
#include "octavo/render/animated_webp.h"
#include "octavo/tasks/pictures/video_pipe.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Whether a name ends in .apng, .webp or .mp4.
bool is_animation(const std::string& path);

/// How many pictures of which size follow each other, and how fast.
struct AnimationFrame {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::uint32_t pictures = 1;
  int fps = 12;
};

class AnimationFile {
 public:
  /// Throws as VideoPipe
  AnimationFile(const std::string& path, const AnimationFrame& frame, const TaskContext& context);

  /// Writes one picture. Throws as PictureFiles::add, AnimatedPng, AnimatedWebp and VideoPipe
  void add(const Picture& picture);

  /// Requires that all pictures were added. Throws Error{io} where the name is taken and not to be
  /// overwritten, and as finish of AnimatedWebp and VideoPipe
  void publish(bool overwrite);

 private:
  const TaskContext& context_;
  std::unique_ptr<PendingFile> file_;
  std::unique_ptr<AnimatedPng> png_;  // one of the three
  std::unique_ptr<AnimatedWebp> webp_;
  std::unique_ptr<VideoPipe> video_;
};

}  // namespace octavo
