// Volume, bounding box, centroid and second moments of a mask, from its tree.
//
// Words and full children are summed as ops/measure/cube_moments.h says, each visited once.
//
// Source  thesis 1.2
#pragma once

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/measure/moment_sums.h"

namespace octavo {

/// Exact sums over the voxels of a mask. Uses the threads of the calling task arena.
MomentSums mask_moments(const MaskTree& mask);

}  // namespace octavo
