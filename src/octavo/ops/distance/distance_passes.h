// Signed distances of the voxels of a mask: three passes over a block of planes, an axis each.
//
//     x  rows of the mask           -> squared distances along rows
//     y  columns of each plane      -> those in the plane
//     z  columns through all planes -> those in the block
//
// What lies outside the block counts for nothing: no distance ends there.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/distance/line_distance.h"

namespace octavo {

/// What distances are measured in.
struct DistanceSettings {
  DistanceTo to = DistanceTo::faces;
  Point3 spacing_mm = {1, 1, 1};
};

/// Voxels of which some are inside: those of a mask, or what is computed of one.
struct InsideVoxels {
  Size3 size;
  /// Writes 1 or 0 for every voxel of a box, [z][y][x]. Is called from several threads.
  std::function<void(const Box& box, std::uint8_t* inside)> fill;
};

/// Those of a mask, which must outlive it.
InsideVoxels inside_of(const MaskTree& mask);

/// The smallest spacing: squares count in its square, so that they are whole where voxels are
/// cubes.
double distance_unit_mm(const DistanceSettings& settings) noexcept;

/// The weight of a step along an axis in such squares.
double distance_weight(const DistanceSettings& settings, int axis) noexcept;

/// Squared distances within planes [begin, end) signed as line_distance.h says.
/// Uses the threads of the calling task arena, as all below.
/// squared  [z][y][x] of these planes
/// Throws   Error{cancelled}
void measure_planes(const InsideVoxels& voxels, std::int64_t begin, std::int64_t end,
                    const DistanceSettings& settings, Progress& progress, float* squared);

/// The pass along z, in place.
/// block  [z][y][x] without gaps
void measure_columns(const Size3& block, const DistanceSettings& settings, float* squared);

/// The distances of squares, mm, signed.
/// limit_mm  those beyond it become it; infinite: none
void to_distances(std::int64_t count, const DistanceSettings& settings, double limit_mm,
                  const float* squared, float* mm);

/// Distances to the voxels of the other class in mm, [z][y][x]: below 0 inside, above 0 outside,
/// infinite everywhere where there is but one class.
/// Memory  4 bytes a voxel
std::vector<float> signed_distances(const MaskTree& mask, const DistanceSettings& settings,
                                    Progress& progress);

}  // namespace octavo
