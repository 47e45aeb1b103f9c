// Union, intersection, difference and symmetric difference of masks, and the complement: one
// traversal of two trees side by side, word by word.
//
// At every cube the four kinds of pairs of children are told apart by words:
//
//     one full or empty, the other mixed   the result is full, empty, a copy or an inverted copy:
//                                          decided, or copied as one run of every array below
//     both mixed                           entered; at the bottom one operation on two words
//     neither mixed                        one operation on the two words of full children
//
// Consequence: a traversal only enters where both surfaces pass; elsewhere runs are copied.
//
// Source  thesis 1.2
#pragma once

#include <cstdint>

#include "octavo/octree/mask_tree.h"

namespace octavo {

enum class SetOperation : std::uint8_t {
  unite,         ///< in a or in b
  intersect,     ///< in a and in b
  subtract,      ///< in a and not in b
  exclusive_or,  ///< in one of them
};

/// The voxels that `operation` leaves of two masks. Uses the threads of the calling task arena;
/// the result does not depend on their number.
/// Throws Error{invalid_argument} when the volumes differ in size.
MaskTree combine(const MaskTree& a, const MaskTree& b, SetOperation operation);

/// The voxels of the volume that are not in `a`. Throws nothing but std::bad_alloc.
MaskTree complement(const MaskTree& a);

}  // namespace octavo
