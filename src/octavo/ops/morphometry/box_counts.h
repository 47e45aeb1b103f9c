// Fractal dimension of a mask: how the number of cubes that hold some of it grows as they become
// smaller. The cubes are the octants of its tree, so nothing but the tree is read.
//
//     octants of level k that hold some of the mask
//         = mixed octants of level k + sum over levels j >= k of leaves of level j * 8^(j - k)
//
// The mixed ones alone are those that the surface runs through.
//
// Source  thesis 2.3; B. B. Mandelbrot, The Fractal Geometry of Nature, 1982
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "octavo/octree/mask_tree.h"

namespace octavo {

/// Octants of one level.
struct BoxCount {
  std::int64_t side = 1;      ///< voxels
  std::uint64_t holding = 0;  ///< some or nothing but the mask
  std::uint64_t mixed = 0;    ///< both classes
};

/// The line through the logarithms of side and count.
struct FractalFit {
  double dimension = 0;
  double r2 = 0;  ///< share of the variance that the line explains
  std::int64_t smallest_side = 0;  ///< voxels
  std::int64_t largest_side = 0;
};

/// Of each level, voxels first, up to the root.
std::vector<BoxCount> box_counts(const MaskTree& mask);

/// The fit over sides from 2 voxels to a quarter of the shortest axis; nothing where these are
/// fewer than 3, or a count is 0.
/// of_surface  counts mixed octants in place of all
std::optional<FractalFit> fractal_dimension(const std::vector<BoxCount>& counts, const Size3& size,
                                            bool of_surface);

}  // namespace octavo
