// The bricks of a grid as an octree that ranks share: each owns whole nodes.
//
//     Morton order of the bricks  |  rank 0  |  rank 1  |  rank 2  |     as much to see for each
//     nodes                       [   ][ ][][][ ][   ]...                the largest that one owns
//
// A run of the Morton order is not convex, but nodes are: rays come to them in the order of the
// octants.
//
// Source  thesis 1.3.3
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/render/rays/ray_job.h"
#include "octavo/render/rays/ray_regions.h"

namespace octavo {

struct OctreeNode {
  int rank = 0;
  Index3 lo;               ///< bricks
  std::int64_t side = 1;   ///< bricks, a power of two

  bool operator==(const OctreeNode&) const = default;
};

/// Shares bricks out. What nothing is seen of weighs 1/16 of another brick.
/// is_seen  by brick, x fastest
std::vector<OctreeNode> share_octree(const Size3& grid, const std::vector<bool>& is_seen,
                                     int ranks);

/// The same nodes in an order in which every ray of a frame comes to them.
/// brick_side  samples
std::vector<OctreeNode> nodes_in_order(std::vector<OctreeNode> nodes, const RayFrame& frame,
                                       std::int64_t brick_side);

/// What of regions lies in a node, in their order; parts of the same boxes.
std::vector<RayRegion> regions_in(const OctreeNode& node, std::span<const RayRegion> regions,
                                  std::int64_t brick_side);

}  // namespace octavo
