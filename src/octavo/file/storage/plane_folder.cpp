#include "octavo/file/storage/plane_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>

namespace octavo {

namespace {

constexpr std::string_view kPrefix = "plane_";
constexpr std::string_view kEnding = ".tif";
constexpr std::size_t kMinDigits = 4;

using OpenFolder = std::unique_ptr<DIR, int (*)(DIR*)>;

// The folder itself, never what a link of that name leads to; null with errno set.
OpenFolder open_folder(const std::string& folder) {
  constexpr int kFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
  OpenFolder entries(nullptr, ::closedir);
  const int descriptor = ::open(folder.c_str(), kFlags);
  if (descriptor < 0) return entries;
  entries.reset(::fdopendir(descriptor));
  if (!entries) {
    const int reason = errno;
    ::close(descriptor);
    errno = reason;
  }
  return entries;
}

bool is_plane(DIR* folder, const std::string& name) {
  struct stat status {};
  return is_plane_name(name) &&
         ::fstatat(::dirfd(folder), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 &&
         S_ISREG(status.st_mode);
}

bool list_open(DIR* folder, PlaneList& list) {
  for (;;) {
    errno = 0;
    const dirent* const entry = ::readdir(folder);
    if (entry == nullptr) return errno == 0;
    const std::string name = entry->d_name;
    if (name == "." || name == "..") continue;
    if (is_plane(folder, name)) {
      list.planes.push_back(name);
    } else {
      list.other = name;
    }
  }
}

}  // namespace

std::string plane_name(std::int64_t z, std::int64_t plane_count) {
  const std::size_t width = std::max(kMinDigits, std::to_string(plane_count - 1).size());
  const std::string digits = std::to_string(z);
  return std::string(kPrefix) + std::string(width - digits.size(), '0') + digits +
         std::string(kEnding);
}

bool is_plane_name(std::string_view name) {
  if (!name.starts_with(kPrefix) || !name.ends_with(kEnding)) return false;
  name.remove_prefix(kPrefix.size());
  if (name.size() < kMinDigits + kEnding.size()) return false;
  name.remove_suffix(kEnding.size());
  return name.find_first_not_of("0123456789") == std::string_view::npos;
}

bool list_planes(const std::string& folder, PlaneList& list) {
  const OpenFolder entries = open_folder(folder);
  return entries && list_open(entries.get(), list);
}

bool remove_plane_folder(const std::string& folder) {
  const OpenFolder entries = open_folder(folder);
  PlaneList list;
  if (!entries || !list_open(entries.get(), list)) return false;
  if (!list.other.empty()) {
    errno = ENOTEMPTY;
    return false;
  }
  for (const std::string& plane : list.planes) {
    if (::unlinkat(::dirfd(entries.get()), plane.c_str(), 0) != 0 && errno != ENOENT) return false;
  }
  return ::rmdir(folder.c_str()) == 0;
}

}  // namespace octavo
