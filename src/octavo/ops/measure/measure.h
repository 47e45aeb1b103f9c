// What the regions of a label map measure, and what a grey volume holds beneath them.
//
// Bricks are taken in file order. A brick of one label among bricks of the same label, over grey
// voxels of one value, is settled from the index; others are decoded once, run by run along x.
// Sums are exact where voxels are integers, and are added in file order, so the result does not
// depend on the number of threads.
//
// Source  thesis 1.2
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"

namespace octavo {

/// The grey voxels of one region, in stored units. Those that are NaN or infinite are counted and
/// in no other number, which are NaN where there are no others.
struct GreyStatistics {
  std::uint64_t not_finite = 0;
  double mean = 0;
  double deviation = 0;  ///< of the population
  double minimum = 0;
  double maximum = 0;
  double sum = 0;
  /// As many as were asked for: the smallest value that this share of the voxels does not exceed.
  std::vector<double> percentiles;
};

/// One region. Positions and moments are in index space: x, y, z of voxel centers.
struct RegionMeasure {
  std::int64_t label = 0;
  std::uint64_t voxel_count = 0;
  std::uint64_t surface_voxel_count = 0;  ///< of which a face neighbor is not in the region
  Box box;
  std::array<double, 3> centroid{};
  std::array<double, 6> covariance{};     ///< xx, yy, zz, xy, xz, yz
  std::optional<GreyStatistics> grey;
};

/// The spread of a region along its own axes, in mm and world space.
struct PrincipalAxes {
  std::array<double, 3> moments_mm2{};  ///< variances, the largest first
  std::array<Point3, 3> axes{};         ///< unit vectors, largest component positive
};

struct RegionMeasureOptions {
  std::vector<double> percentiles = {5, 25, 50, 75, 95};  ///< of 0 .. 100
  bool falls = false;  ///< the scale of grey values does: percentiles count from the largest down
  std::vector<std::int64_t> labels = {};  ///< only these, ascending; none: all but 0
};

/// The regions of all labels but 0 that are asked for and have voxels, ascending; bricks without
/// any of them are not decoded. Uses the threads of the calling task arena.
/// grey  nullptr, or a volume on the same grid
/// Throws what the readers throw, Error{cancelled}; Error{invalid_argument} for a grey volume in
///        place of labels, or of another size
/// Memory  64 bricks and their sums; per label 500 bytes, and per percentile 2 bytes a voxel of it
///         up to 64 KiB
/// Time    one pass over the voxels; with percentiles one more where the values of the volume span
///         over 2^13, and a third where they do 2^26
std::vector<RegionMeasure> measure_regions(const FileReader& labels, const FileReader* grey,
                                           const RegionMeasureOptions& options,
                                           Progress& progress);

/// The principal axes of a region on a grid.
PrincipalAxes principal_axes(const RegionMeasure& region, const Geometry& geometry);

}  // namespace octavo
