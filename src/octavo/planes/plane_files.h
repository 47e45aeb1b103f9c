// Which files the planes of a source are read from.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
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

/// What one plane is made of.
struct PlaneOrigin {
  std::size_t below = 0;       ///< the slice at the plane's height, or the next one below
  double weight_above = 0;     ///< of the slice after `below`; 0: `below` alone
  bool is_background = false;  ///< no slice speaks of it: a segmentation leaves empty slices out

  bool operator==(const PlaneOrigin&) const = default;
};

/// Tilted slices moved within their planes until they stand above one another.
struct TiltRemoval {
  double angle_degrees = 0;
  std::vector<std::array<double, 2>> shift;  ///< of each slice on the canvas, in voxels, >= 0
  std::int64_t columns = 0;                  ///< of the canvas, which holds all slices whole
  std::int64_t rows = 0;
  double outside = 0;                        ///< the stored value where no slice reaches

  bool operator==(const TiltRemoval&) const = default;
};

/// How slices become planes where each file holds one slice and nothing but these counts.
struct SliceOutline {
  std::vector<PlaneOrigin> planes;      ///< empty: the slices are the planes
  std::optional<TiltRemoval> tilt;
  std::optional<std::int64_t> padding;  ///< the stored value that takes part in no mixing

  bool operator==(const SliceOutline&) const = default;
};

struct PlaneFiles {
  /// Absolute, each once: a header before its data, slices in the order of planes, what else is
  /// read behind them. None where voxels stand in no file, or behind a URL.
  std::vector<std::string> paths;
  /// The files that each plane is made of; empty where any plane may be made of all of them.
  std::vector<FileRange> of_plane;
  /// Where some of the files can be opened without the others: path i holds slice i.
  std::optional<SliceOutline> outline = {};
  /// What stands beside an export of this program: the SHA-256 of its voxels; empty of others.
  std::string voxels_sha256 = {};

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

/// The outline of slices that are the planes, each in a file of its own; nothing of others, and of
/// a single one.
std::optional<SliceOutline> outline_of_slices(const PlaneFiles& files);

}  // namespace octavo
