// The voxel that a place belongs to: one rule for other grids, slices and single places.
//
//     voxel           3       4       5
//     its box     |-------|-------|-------|
//     halfway             4       5       6      the border belongs to the higher index
//
// A place up to 1e-6 voxels before a border counts as on it: the same place, reached by other maps,
// is rounded to either side of it.
#pragma once

#include <cmath>
#include <cstdint>

namespace octavo {

/// Voxels.
inline constexpr double kBorderSlack = 1e-6;

/// The index along an axis of the voxel whose box holds a place; halfway between two, the higher.
inline std::int64_t nearest_voxel(double place) {
  return static_cast<std::int64_t>(std::floor(place + (0.5 + kBorderSlack)));
}

/// Whether a place lies in the box of one of `size` voxels, or on the border of them all.
inline bool is_in_voxels(double place, std::int64_t size) {
  return place >= -0.5 - kBorderSlack &&
         place <= static_cast<double>(size) - 0.5 + kBorderSlack;
}

}  // namespace octavo
