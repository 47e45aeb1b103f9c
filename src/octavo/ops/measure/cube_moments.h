// Moments of what a cube holds, a word at a time.
//
// The bits of a word are at coordinates 0..3, so all their sums follow from counts of bits under 21
// masks; children of any side are summed in the same way, and scaled.
//
// Source  thesis 1.2
#pragma once

#include <cstdint>

#include "octavo/ops/measure/moment_sums.h"

namespace octavo {

/// Adds the children of a cube whose bits are set.
/// side    of a child, voxels
/// corner  the first voxel of the cube
void add_children(std::uint64_t bits, std::int64_t side, const Index3& corner, MomentSums& to);

/// Adds the voxels of some words of a cube of 16^3.
/// mixed  which of its children they are
/// words  one for each bit of `mixed`, none of them empty
void add_words(std::uint64_t mixed, const std::uint64_t* words, const Index3& corner,
               MomentSums& to);

}  // namespace octavo
