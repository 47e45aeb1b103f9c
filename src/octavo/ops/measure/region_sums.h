// Sums over the voxels of regions, and what regions measure by them.
//
// Invariants
//   Sums are exact: neither the order in which voxels are added nor the parts of a volume in which
//   they are summed change a digit of what a region measures.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/file/reader.h"
#include "octavo/ops/measure/exact_sum.h"
#include "octavo/ops/measure/moment_sums.h"

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

/// Of the voxels of one region.
struct RegionSums {
  MomentSums moments;
  std::uint64_t surface = 0;
  std::uint64_t not_finite = 0;  ///< grey voxels that enter none of the following
  double minimum = std::numeric_limits<double>::infinity();
  double maximum = -std::numeric_limits<double>::infinity();
  // Of integers less the smallest of the volume
  __int128 whole_sum = 0;
  __int128 whole_squares = 0;
  ExactSum floats;

  void add(const RegionSums& other);
};

/// What a region measures by its sums; percentiles are left out.
/// grey  nullptr, or the volume that was summed
RegionMeasure measured_by(std::int64_t label, const RegionSums& sums, const FileReader* grey);

}  // namespace octavo
