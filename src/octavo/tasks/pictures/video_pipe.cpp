#include "octavo/tasks/pictures/video_pipe.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <vector>

#include "octavo/core/error.h"

extern char** environ;

namespace octavo {

namespace {

[[noreturn]] void fail_video(const std::string& path, const std::string& what) {
  throw Error(ErrorKind::io, what, path).with_field("animation.ffmpeg");
}

}  // namespace

VideoPipe::VideoPipe(const std::string& path, std::int64_t width, std::int64_t height, int fps)
    : path_(path), width_(width), height_(height) {
  // A socket: one that nobody reads any more fails without a signal.
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    fail_video(path, "no pipe to ffmpeg");
  }
  socket_ = ends[0];
  std::vector<std::string> words = {
      "ffmpeg", "-loglevel", "quiet", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
      fmt::format("{}x{}", width, height), "-r", std::to_string(fps), "-i", "pipe:0",
      // Colors are kept by 2 x 2 pixels.
      "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "18", "-pix_fmt",
      "yuv420p", "-movflags", "+faststart", "-f", "mp4", path};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_WRONLY, 0);
  }
  const int failure =
      posix_spawnp(&process_, "ffmpeg", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  if (failure == 0) return;
  ::close(socket_);
  fail_video(path, "MP4 files are written by the program ffmpeg, which this machine does not have");
}

VideoPipe::~VideoPipe() {
  if (socket_ >= 0) ::close(socket_);
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void VideoPipe::add(const Picture& picture) {
  if (picture.width != width_ || picture.height != height_) {
    throw Error(ErrorKind::invalid_argument, "the pictures of an animation have one size", path_);
  }
  const Picture colors = in_colors(picture);
  for (std::size_t sent = 0; sent < colors.pixels.size();) {
    const ssize_t bytes = ::send(socket_, colors.pixels.data() + sent,
                                 colors.pixels.size() - sent, MSG_NOSIGNAL);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) fail_video(path_, "ffmpeg ended before the last picture");
    sent += static_cast<std::size_t>(bytes);
  }
}

void VideoPipe::finish() {
  ::close(socket_);
  socket_ = -1;
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  const bool is_done = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (!is_done) fail_video(path_, "ffmpeg failed to write a video in H.264");
}

}  // namespace octavo
