#include "octavo/file/plane_folder.h"

#include <dirent.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <vector>

namespace octavo {

namespace {

constexpr std::string_view kPrefix = "plane_";
constexpr std::string_view kEnding = ".tif";
constexpr std::size_t kLeastDigits = 4;

bool is_regular_file(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode);
}

// The planes of a folder; false with errno set when it holds anything else or cannot be listed.
bool list_planes(const std::string& folder, std::vector<std::string>& planes) {
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(folder.c_str()), ::closedir);
  if (!entries) return false;
  for (;;) {
    errno = 0;
    const dirent* const entry = ::readdir(entries.get());
    if (entry == nullptr) return errno == 0;
    const std::string name = entry->d_name;
    if (name == "." || name == "..") continue;
    planes.push_back(folder + "/" + name);
    if (is_plane_name(name) && is_regular_file(planes.back())) continue;
    errno = ENOTEMPTY;
    return false;
  }
}

}  // namespace

std::string plane_name(std::int64_t z, std::int64_t plane_count) {
  const std::size_t width = std::max(kLeastDigits, std::to_string(plane_count - 1).size());
  const std::string digits = std::to_string(z);
  return std::string(kPrefix) + std::string(width - digits.size(), '0') + digits +
         std::string(kEnding);
}

bool is_plane_name(std::string_view name) {
  if (!name.starts_with(kPrefix) || !name.ends_with(kEnding)) return false;
  name.remove_prefix(kPrefix.size());
  if (name.size() < kLeastDigits + kEnding.size()) return false;
  name.remove_suffix(kEnding.size());
  return name.find_first_not_of("0123456789") == std::string_view::npos;
}

bool remove_plane_folder(const std::string& folder) {
  std::vector<std::string> planes;
  if (!list_planes(folder, planes)) return false;
  for (const std::string& plane : planes) {
    if (::unlink(plane.c_str()) != 0 && errno != ENOENT) return false;
  }
  return ::rmdir(folder.c_str()) == 0;
}

}  // namespace octavo
