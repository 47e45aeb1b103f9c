// The components of a mask as a label map.
//
// Parts of words and cubes have their labels already, so that no voxel is looked at: cubes of 64^3
// are folded on all threads and joined.
#pragma once

#include <cstddef>
#include <cstdint>

#include "octavo/core/progress.h"
#include "octavo/octree/label_tree.h"
#include "octavo/ops/mask/components.h"

namespace octavo {

/// The label map of the first `kept` components, the largest ones: 1, 2, ...; all else is 0. Uses
/// the threads of the calling task arena.
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the tree needs more
/// watcher    says when to stop, with Error{cancelled}; null: never
LabelTree labels_of_components(const Components& found, std::size_t kept,
                               std::uint64_t max_bytes = 0, const Progress* watcher = nullptr);

}  // namespace octavo
