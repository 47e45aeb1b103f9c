// Pictures as a video, by the program ffmpeg where this machine has one.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/render/picture.h"

namespace octavo {

class VideoPipe {
 public:
  /// Starts ffmpeg, which writes H.264 in MP4 to a file that is there already.
  /// Throws Error{io} where no ffmpeg is found
  VideoPipe(const std::string& path, std::int64_t width, std::int64_t height, int fps);
  /// Ends ffmpeg.
  ~VideoPipe();
  VideoPipe(const VideoPipe&) = delete;
  VideoPipe& operator=(const VideoPipe&) = delete;

  /// Sends one picture. Throws Error{invalid_argument} for another size, Error{io} where ffmpeg has
  /// ended
  void add(const Picture& picture);

  /// Waits for the end of the file. Throws Error{io} where ffmpeg failed
  void finish();

 private:
  std::string path_;
  std::int64_t width_;
  std::int64_t height_;
  int socket_ = -1;
  int process_ = -1;
};

}  // namespace octavo
