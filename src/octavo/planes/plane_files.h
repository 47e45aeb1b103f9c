// Which files the planes of a source are read from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace octavo {

/// Files first .. end of PlaneFiles::paths; none where both are the same.
struct FileRange {
  std::int64_t first = 0;
  std::int64_t end = 0;

  bool is_empty() const { return first == end; }
  bool operator==(const FileRange&) const = default;
};

/// The smallest range that holds both.
FileRange joined(FileRange a, FileRange b);

struct PlaneFiles {
  /// Absolute, each once: a header before its data, slices in the order of planes, what else is
  /// read behind them. None where voxels stand in no file, or behind a URL.
  std::vector<std::string> paths;
  /// The files that each plane is made of; empty where any plane may be made of all of them.
  std::vector<FileRange> of_plane;

  bool operator==(const PlaneFiles&) const = default;
};

/// The range that holds the files of planes first .. end. Complexity linear in the planes
FileRange files_of_planes(const PlaneFiles& files, std::int64_t first, std::int64_t end);

/// The files of a volume that no file holds one plane of: a path given twice counts once, a URL not
/// at all.
PlaneFiles files_of_volume(const std::vector<std::string>& paths);

/// The files of planes that stand in one file each.
/// paths  of each plane; planes may share a file
PlaneFiles files_of_slices(const std::vector<std::string>& paths);

}  // namespace octavo
