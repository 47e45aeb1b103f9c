// The leaves of a mask that are not hidden among others.
//
// A leaf is dropped when the six cubes of its size beside it lie in leaves of the same or a larger
// size. For the 64 children of a cube this is a handful of operations on words: the bits of the
// full children, those of the same cube's neighbors, and for leaves of twice the size their bytes.
//
//     children   drop = full & (full one step along each of six ways, across the border if need be)
//     octants    the same with the bytes that are all ones
//
// Source  thesis 4.6
#pragma once

#include <cstdint>

#include "octavo/octree/mask_tree.h"

namespace octavo {

/// The mask without its hidden leaves; the leaves of the result are leaves of `mask`. What lies
/// outside the volume hides nothing. Uses the threads of the calling task arena; the result does
/// not depend on their number.
/// Memory  that of the mask once more beside the result; linear in its stored words
MaskTree shell(const MaskTree& mask);

/// Leaves of the condensed octree.
std::int64_t leaf_count(const MaskTree& mask);

/// The smallest box that holds the mask; empty at the origin for an empty mask.
Box bounding_box(const MaskTree& mask);

}  // namespace octavo
