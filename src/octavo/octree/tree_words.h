// The words of a box of a tree: what the bricks of a volume are, read off its octree.
//
// A box is a part of a cube of 64^3 voxels on their grid and of the volume; it starts at multiples
// of 4 and ends at such or where the volume does.
#pragma once

#include <optional>

#include "octavo/octree/label_tree.h"
#include "octavo/octree/label_words.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// The words of a box. Thread-safe.
void words_of(const MaskTree& tree, const Box& box, LabelWords& words);
void words_of(const LabelTree& tree, const Box& box, LabelWords& words);

/// The label of all voxels of a box; nothing when they have several. Thread-safe.
std::optional<std::int64_t> only_label(const MaskTree& tree, const Box& box);
std::optional<std::int64_t> only_label(const LabelTree& tree, const Box& box);

}  // namespace octavo
