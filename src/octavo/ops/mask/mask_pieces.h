// Masks made in pieces: sub-trees on many threads, put together in o-code order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/octree/mask_tree.h"

namespace octavo {

/// Below this many words one thread is done sooner than many can be started.
inline constexpr std::size_t kWordsPerTask = 16384;

/// A cube of some rank: what it is and where it lies among the cubes of its rank.
struct MaskPiece {
  std::uint64_t code = 0;
  MaskCube cube;
};

/// Neighboring cubes of one rank in ascending order of codes, with everything below them. Places
/// in the cubes count from the start of the arrays here.
struct MaskPart {
  std::vector<MaskPiece> pieces;  ///< empty ones may be left out
  MaskArrays below;               ///< of all lower ranks
};

/// Bytes that a part holds.
std::uint64_t memory_bytes(const MaskPart& part) noexcept;

/// Makes a cube of words: full ones are noted, mixed ones kept for the array below.
class WordCube {
 public:
  /// The next child, at `bit`; bits ascend.
  void add(int bit, std::uint64_t word) {
    const std::uint64_t is_full = word == kFullWord ? 1 : 0;
    const std::uint64_t is_mixed = word != 0 && word != kFullWord ? 1 : 0;
    mixed_words_[count_] = word;
    count_ += is_mixed;
    full_ |= is_full << bit;
    mixed_ |= is_mixed << bit;
  }

  /// The cube, after appending its mixed words.
  MaskCube finish(std::vector<std::uint64_t>& words) const {
    const MaskCube cube{full_, mixed_, words.size()};
    words.insert(words.end(), mixed_words_.begin(),
                 mixed_words_.begin() + static_cast<std::ptrdiff_t>(count_));
    return cube;
  }

 private:
  std::uint64_t full_ = 0;
  std::uint64_t mixed_ = 0;
  std::size_t count_ = 0;
  std::array<std::uint64_t, 64> mixed_words_;
};

/// Takes a cube as the child of `parent` at `bit`: kept in `below`, the array of its rank, when it
/// is mixed.
inline void add_child(const MaskCube& child, int bit, MaskCube& parent,
                      std::vector<MaskCube>& below) {
  const std::uint64_t here = std::uint64_t{1} << bit;
  if (child.is_full()) {
    parent.full |= here;
  } else if (!child.is_empty()) {
    below.push_back(child);
    parent.mixed |= here;
  }
}

/// Arrays for what lies below a cube of `rank`.
MaskArrays arrays_below(int rank);

/// The cube of 64^3 voxels with that code, of its 4096 words in o-code order.
MaskPart fold_cube(const std::uint64_t* words, std::uint64_t code);

/// The tree of parts whose codes ascend from one part to the next.
/// rank  of the pieces
/// Requires that every piece lies in the universe of `size`. Voxels beyond the volume are taken as
/// they come; a tree with any is not valid until they are cut off.
MaskTree assemble(const Size3& size, int rank, std::span<const MaskPart> parts);

/// Appends stored cubes of `rank`, neighbors in the array, and all that is below them. Inverted:
/// full and empty change places.
void append_cubes(const MaskTree& from, int rank, std::uint64_t begin, std::uint64_t end,
                  bool is_inverted, MaskArrays& out);

/// The cubes of `rank` at which work on a tree is split: stored or full.
std::vector<MaskPiece> pieces_at(const MaskTree& tree, int rank);

}  // namespace octavo
