#include "octavo/planes/plane_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "octavo/core/url_text.h"

namespace octavo {

namespace {

/// Links and ".." stay: what a path names is for who opens it to find out.
std::vector<std::string> absolute(std::vector<std::string> paths) {
  std::string folder;  // asked for once at most
  for (std::string& path : paths) {
    if (path.starts_with('/')) continue;
    if (folder.empty()) folder = (std::filesystem::current_path() / "").string();
    path = folder + path;
  }
  return paths;
}

}  // namespace

FileRange joined(FileRange a, FileRange b) {
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  return {std::min(a.first, b.first), std::max(a.end, b.end)};
}

FileRange files_of_planes(const PlaneFiles& files, std::int64_t first, std::int64_t end) {
  if (first == end) return {};
  if (files.of_plane.empty()) return {0, static_cast<std::int64_t>(files.paths.size())};
  FileRange range;
  for (std::int64_t z = first; z < end; ++z) {
    range = joined(range, files.of_plane[static_cast<std::size_t>(z)]);
  }
  return range;
}

PlaneFiles files_of_volume(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (is_url(path) || std::ranges::find(files, path) != files.end()) continue;
    files.push_back(path);
  }
  return {absolute(std::move(files)), {}, {}};
}

PlaneFiles files_of_slices(const std::vector<std::string>& paths) {
  PlaneFiles files;
  std::map<std::string, std::int64_t> known;
  for (const std::string& path : paths) {
    const auto count = static_cast<std::int64_t>(files.paths.size());
    const auto [found, is_new] = known.emplace(path, count);
    if (is_new) files.paths.push_back(path);
    files.of_plane.push_back({found->second, found->second + 1});
  }
  files.paths = absolute(std::move(files.paths));
  return files;
}

std::optional<SliceOutline> outline_of_slices(const PlaneFiles& files) {
  const bool is_stack = files.paths.size() > 1 && files.paths.size() == files.of_plane.size();
  return is_stack ? std::optional(SliceOutline{}) : std::nullopt;
}

}  // namespace octavo
