// The balls that fit into one class of a mask: what local thickness is made of.
//
// Around every voxel's center there is a largest ball that holds no center of the other class. It
// covers the voxels that it holds the centers of. The surface lies between the centers inside and
// those outside:
//
//     o  o  o  |  .  .      where it faces an axis or a diagonal, half way between two layers of
//     o  o  o  |  .  .      centers: half a voxel before the center that the ball meets
//
//     o  o  o . .           everywhere else, some center lies close to it: at the center that the
//     o  o . . .            ball meets
//
// The middle of a plate that is an even number of voxels thick lies at corners between voxels, so
// that balls that meet the other class along an axis are there around corners as well.
//
// Few balls are needed: one that lies within a larger one is not. The larger one is looked for
// where distances grow, at a few steps up to four voxels.
//
// Source  T. Hildebrand, P. Rüegsegger, A new method for the model-independent assessment of
//         thickness in three-dimensional images, Journal of Microscopy 185 (1997)
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"
#include "octavo/ops/distance/distance_field.h"

namespace octavo {

/// Voxels whose thickness is asked for.
struct ThicknessClass {
  const MaskTree& mask;
  const MaskTree* region = nullptr;  ///< that balls begin in and voxels are measured in; null: all
  bool is_background = false;        ///< of what is not in the mask
};

struct FittingBall {
  /// Center, in half voxels: 2 * index + 1 of a voxel's center, 2 * index of the corner before it.
  std::array<std::int32_t, 3> half_index{};
  float radius_mm = 0;  ///< to the surface: half of the thickness
  float reach_mm = 0;   ///< it covers voxels whose centers are nearer
};

/// Where fields of distances are held.
struct BallRoom {
  std::uint64_t max_bytes = std::uint64_t{1} << 30;  ///< of both fields in memory
  Storage& storage;
  std::string folder;  ///< of scratch files
};

/// By how much a ball may reach out of the larger one for which it is left out, voxels.
inline constexpr double kBallTolerance = 0.05;

/// Balls that cover all that the balls around all centers and corners cover, within the tolerance;
/// the largest first. Requires that both classes have voxels.
/// Uses the threads of the calling task arena; does not depend on them.
/// Throws  Error{io}, Error{cancelled}
/// Memory  max_bytes, 20 bytes a ball and 24 planes of two floats a voxel
std::vector<FittingBall> fitting_balls(const ThicknessClass& asked, const Point3& spacing_mm,
                                       const BallRoom& room, Progress& progress);

}  // namespace octavo
