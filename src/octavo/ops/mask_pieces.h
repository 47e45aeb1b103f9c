// Masks made in pieces: sub-trees on many threads, put together in o-code order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/mask_tree.h"

namespace octavo {

/// A cube of some rank: what it is and where it lies among the cubes of its rank.
struct MaskPiece {
  std::uint64_t code = 0;
  MaskCube cube;
};

/// Neighbouring cubes of one rank in ascending order of codes, with everything below them. Places
/// in the cubes count from the start of the arrays here.
struct MaskPart {
  std::vector<MaskPiece> pieces;  ///< empty ones may be left out
  MaskArrays below;               ///< of all lower ranks
};

/// Arrays for what lies below a cube of `rank`.
MaskArrays arrays_below(int rank);

/// The tree of parts whose codes ascend from one part to the next.
/// rank  of the pieces
/// Requires that every piece lies in the volume.
MaskTree assemble(const Size3& size, int rank, std::span<const MaskPart> parts);

/// Appends stored cubes of `rank`, neighbours in the array, and all that is below them. Inverted:
/// full and empty change places.
void append_cubes(const MaskTree& from, int rank, std::uint64_t begin, std::uint64_t end,
                  bool is_inverted, MaskArrays& out);

/// The cubes of `rank` at which work on a tree is split: stored or full.
std::vector<MaskPiece> pieces_at(const MaskTree& tree, int rank);

}  // namespace octavo
