#include "common/web_browser.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <thread>

extern char** environ;

namespace octavo::cli {

namespace {

namespace fs = std::filesystem;

bool starts(const std::string& program, const std::string& url) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  // What a browser prints is not ours.
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
  }
  std::string name = program;
  std::string address = url;
  char* arguments[] = {name.data(), address.data(), nullptr};
  pid_t process = 0;
  const int failure =
      posix_spawnp(&process, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) return false;
  // Nobody else waits for its end.
  std::thread([process] { ::waitpid(process, nullptr, 0); }).detach();
  return true;
}

}  // namespace

std::string web_page_folder() {
  if (const char* folder = std::getenv("OCTAVO_WEB"); folder != nullptr && *folder != 0) {
    return folder;
  }
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none);
  for (const char* place : {"share/octavo/web", "../share/octavo/web"}) {
    const fs::path folder = program.parent_path() / place;
    if (fs::exists(folder / "index.html", none)) return folder.lexically_normal().string();
  }
  return "";
}

bool open_in_browser(const std::string& url) {
  if (const char* browser = std::getenv("BROWSER"); browser != nullptr && *browser != 0) {
    return starts(browser, url);
  }
  return starts("xdg-open", url) || starts("open", url);
}

}  // namespace octavo::cli
