// Volume, bounding box, centroid and second moments of a mask, from its tree.
//
// The bits of a word are at coordinates 0..3, so all their sums follow from counts of bits under 21
// masks; the full children of a cube are summed in the same way, at any rank, and scaled. One visit
// per stored word and cube.
//
// Source  thesis 1.2
#pragma once

#include "octavo/core/mask_tree.h"
#include "octavo/ops/moment_sums.h"

namespace octavo {

/// Exact sums over the voxels of a mask. Uses the threads of the calling task arena.
MomentSums mask_moments(const MaskTree& mask);

}  // namespace octavo
