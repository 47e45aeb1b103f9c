// Volume, bounding box, centroid and second moments of every label of a tree, in one traversal.
//
// Source  thesis 1.2
#pragma once

#include <vector>

#include "octavo/octree/label_tree.h"
#include "octavo/ops/measure/moment_sums.h"

namespace octavo {

/// Exact sums over the voxels of each of `tree.labels()`; of 0 there are none. Each word is opened
/// once. Uses the threads of the calling task arena; the result does not depend on their number.
/// Memory  208 bytes per label, and per label and cube of 64^3 of those that are worked on
std::vector<MomentSums> label_moments(const LabelTree& tree);

}  // namespace octavo
