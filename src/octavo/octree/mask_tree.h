// A set of voxels in memory: a tree of 64-bit words in o-code order.
//
// One word is a cube of 4 x 4 x 4 voxels. Bit c of it is the voxel whose code ends in the two
// digits c, so that a byte is an octant of it and the word reads as its voxels sorted by code:
//
//     word   63 ......... 56 | ... | 15 .......... 8 | 7 ........... 0
//            octant 7              octant 1            octant 0 (2 x 2 x 2 voxels)
//
// Above the words stand cubes of 16^3, 64^3, 256^3, ... voxels (rank 0, 1, 2, ...) up to the root.
// A cube has 64 children, the words or the cubes of the rank below, in the same order of codes. Two
// words say of each child whether it is full, mixed or (neither) empty; only mixed children are
// stored, side by side, and the one at bit c is found by counting the mixed ones before it:
//
//     rank 1   full 0000..1  mixed 0110..0  first --.
//     rank 0                                        '-> [cube] [cube] ...
//     words                                               '-> [word] [word] [word] ...
//
// Invariants
//   full and mixed of a cube have no bit in common.
//   Below the root a stored word is neither empty nor full, and no stored cube is either.
//   The children of a rank stand in o-code order: a cube's children begin where those of the cube
//   before it end, also when it has none.
//   No voxel outside `size` is in the set.
// Consequences
//   One set has one tree: equal sets have equal arrays.
//   A sub-tree is one contiguous run of every array below it: it is copied, not visited.
//   A full byte, a full word, a full byte of `full` and a full child are the condensed leaves of
//   levels 1, 2, 3, 4, ...: the linear octree is a view of the tree (`to_linear_octree`).
//   A voxel is reached in one step per rank; memory is 64 bits per mixed 4^3 cube and 24 bytes per
//   mixed cube above it.
//
// Source  thesis 1.2, 2.3; bitmaps with ranks: Jacobson, Space-efficient static trees and graphs,
//         1989
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/octree/linear_octree.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

inline constexpr std::uint64_t kFullWord = ~std::uint64_t{0};

/// Which of 64 children are full and which are stored; the stored ones start at `first` of the
/// array below.
struct MaskCube {
  std::uint64_t full = 0;
  std::uint64_t mixed = 0;
  std::uint64_t first = 0;

  bool operator==(const MaskCube&) const = default;
  bool is_empty() const noexcept { return (full | mixed) == 0; }
  bool is_full() const noexcept { return full == kFullWord; }
  /// Behind the last stored child.
  std::uint64_t end() const noexcept {
    return first + static_cast<std::uint64_t>(std::popcount(mixed));
  }
  /// The place of the stored child at `bit`. Requires that it is mixed.
  std::uint64_t place_of(int bit) const noexcept {
    const std::uint64_t before = mixed & ((std::uint64_t{1} << bit) - 1);
    return first + static_cast<std::uint64_t>(std::popcount(before));
  }
};

/// The arrays of a tree, or of a sub-tree without its root cube.
struct MaskArrays {
  std::vector<std::uint64_t> words;
  std::vector<std::vector<MaskCube>> cubes;  ///< by rank

  bool operator==(const MaskArrays&) const = default;
};

class MaskTree {
 public:
  /// The smallest universe is a cube of rank 1.
  static constexpr int kMinRanks = 2;

  /// The empty set in a volume of `size`. Throws Error{limit_exceeded} on a bad size.
  explicit MaskTree(const Size3& size = {1, 1, 1});

  /// The tree made of `arrays`, whose last rank holds the root alone.
  /// Requires the invariants above (`is_valid` proves them).
  MaskTree(const Size3& size, MaskArrays arrays);

  /// The ranks of cubes in the tree of a volume; the side of its root is 4^(ranks + 1) voxels.
  static int rank_count_for(const Size3& size);

  const Size3& size() const { return size_; }
  int rank_count() const { return static_cast<int>(arrays_.cubes.size()); }
  std::span<const std::uint64_t> words() const { return arrays_.words; }
  std::span<const MaskCube> cubes(int rank) const {
    return arrays_.cubes[static_cast<std::size_t>(rank)];
  }
  const MaskCube& root() const { return arrays_.cubes.back().front(); }
  bool is_empty() const { return root().is_empty(); }
  bool operator==(const MaskTree&) const = default;

  /// Whether a voxel is in the set; false outside the volume. O(ranks), thread-safe.
  bool contains(const Index3& voxel) const noexcept;

  std::uint64_t voxel_count() const noexcept;

  /// Bytes of the arrays.
  std::uint64_t memory_bytes() const noexcept;

 private:
  Size3 size_;
  MaskArrays arrays_;
};

/// Side of the children of a cube of `rank`, voxels; rank -1: of those of a word.
constexpr std::int64_t child_side(int rank) noexcept { return std::int64_t{1} << 2 * (rank + 1); }

/// Side of a cube of rank 1, voxels: that of a brick.
inline constexpr std::int64_t kCubeSide = child_side(2);

/// The box of the child at `bit` of a cube that starts at `corner`, its children `side` voxels
/// long.
inline Box child_box(const Index3& corner, int bit, std::int64_t side) noexcept {
  const Index3 at = place_of_bit(bit);
  const Index3 lo{corner.x + at.x * side, corner.y + at.y * side, corner.z + at.z * side};
  return {lo, {lo.x + side, lo.y + side, lo.z + side}};
}

/// The bits of those children of a cube that meet a box.
std::uint64_t children_in_box(const Index3& corner, std::int64_t side, const Box& box) noexcept;

/// The smallest box around the children whose bits are set; empty when none is.
Box box_of_children(std::uint64_t bits, const Index3& corner, std::int64_t side) noexcept;

/// The 8 octants of a word that are full: bit 8 * octant of the result is set.
constexpr std::uint64_t full_octants(std::uint64_t word) noexcept {
  word &= word >> 1;
  word &= word >> 2;
  word &= word >> 4;
  return word & 0x0101010101010101u;
}

/// True when the invariants of a tree hold, all but the one about voxels outside the volume, which
/// is proven as well unless the volume fills its universe. O(size of the tree)
bool is_valid(const MaskTree& tree);

/// Leaves of each level of the condensed octree, level 0 (voxels) first, up to the root's level n.
std::vector<std::int64_t> leaf_counts(const MaskTree& tree);

/// The leaves as sorted lists of codes, each with `value`. Memory 16 bytes per leaf.
LinearOctree to_linear_octree(const MaskTree& tree, std::int64_t value = 1);

/// Calls visit(OCode) for every leaf of the condensed octree, sub-octree by sub-octree in o-code
/// order.
template <class Visit>
void for_each_leaf(const MaskTree& tree, Visit&& visit);

/// Calls visit(rank, place, corner) for every stored cube that meets `box`, parents first, and with
/// rank -1 for every stored word; corner is the first voxel.
template <class Visit>
void visit_items(const MaskTree& tree, const Box& box, Visit&& visit);

/// Writes `value` for those children of a cube (rank -1: of a word) at `corner` whose bits are set,
/// as far as they lie in `box`, to voxels [z][y][x] of the box.
template <class T>
void fill_children(std::uint64_t bits, int rank, const Index3& corner, const Box& box, T value,
                   T* voxels);

/// Writes 1 or 0 for every voxel of `box` to `voxels`, [z][y][x] without gaps. Thread-safe.
/// T  an integer voxel type
/// Requires a box inside the volume
template <class T>
void fill_voxels(const MaskTree& tree, const Box& box, T* voxels);

/// The tree of all voxels of a box in a volume of `size`; the box is clipped to the volume.
MaskTree box_mask(const Size3& size, const Box& box);

// ---- implementation of the templates

namespace mask_tree_detail {

// The leaves among 64 children of `level`, whose codes are base * 64 + bit.
template <class Visit>
void visit_full(std::uint64_t full, std::uint64_t base, int level, Visit& visit, int octant) {
  std::uint64_t byte = full >> 8 * octant & 0xff;
  const std::uint64_t code = base << 3 | static_cast<std::uint64_t>(octant);
  if (byte == 0xff) {
    visit(OCode{level + 1, code});
    return;
  }
  for (; byte != 0; byte &= byte - 1) {
    visit(OCode{level, code << 3 | static_cast<std::uint64_t>(std::countr_zero(byte))});
  }
}

template <class Visit>
void visit_cube(const MaskTree& tree, int rank, const MaskCube& cube, std::uint64_t code,
                Visit& visit) {
  const int level = 2 * (rank + 1);  // of the children
  if (cube.is_full()) {
    visit(OCode{level + 2, code});
    return;
  }
  std::uint64_t child = cube.first;
  for (int octant = 0; octant < 8; ++octant) {
    std::uint64_t mixed = cube.mixed >> 8 * octant & 0xff;
    if (mixed == 0) {
      visit_full(cube.full, code, level, visit, octant);
      continue;
    }
    const std::uint64_t full = cube.full >> 8 * octant & 0xff;
    for (std::uint64_t both = full | mixed; both != 0; both &= both - 1) {
      const int digit = std::countr_zero(both);
      const std::uint64_t below = code << 6 | static_cast<std::uint64_t>(8 * octant + digit);
      if ((full >> digit & 1) != 0) {
        visit(OCode{level, below});
      } else if (rank == 0) {
        const std::uint64_t word = tree.words()[child++];
        for (int part = 0; part < 8; ++part) visit_full(word, below, 0, visit, part);
      } else {
        visit_cube(tree, rank - 1, tree.cubes(rank - 1)[child++], below, visit);
      }
    }
  }
}

template <class Visit>
void visit_item(const MaskTree& tree, const Box& box, int rank, std::uint64_t place,
                const Index3& corner, Visit& visit) {
  visit(rank, place, corner);
  if (rank < 0) return;
  const MaskCube& cube = tree.cubes(rank)[place];
  const std::uint64_t inside = children_in_box(corner, child_side(rank), box);
  for (std::uint64_t left = cube.mixed & inside; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    const Box child = child_box(corner, bit, child_side(rank));
    visit_item(tree, box, rank - 1, cube.place_of(bit), child.lo, visit);
  }
}

}  // namespace mask_tree_detail

template <class Visit>
void visit_items(const MaskTree& tree, const Box& box, Visit&& visit) {
  mask_tree_detail::visit_item(tree, box, tree.rank_count() - 1, 0, {0, 0, 0}, visit);
}

template <class T>
void fill_children(std::uint64_t bits, int rank, const Index3& corner, const Box& box, T value,
                   T* voxels) {
  const Size3 size = box.size();
  bits &= children_in_box(corner, child_side(rank), box);
  for (; bits != 0; bits &= bits - 1) {
    const Box child = child_box(corner, std::countr_zero(bits), child_side(rank));
    const Box part = intersection(child, box);
    const std::int64_t length = part.hi.x - part.lo.x;
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      T* row = voxels + ((z - box.lo.z) * size.y + part.lo.y - box.lo.y) * size.x + part.lo.x -
               box.lo.x;
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y, row += size.x) {
        if (length == 4) std::fill_n(row, 4, value);  // most are a word long
        else std::fill_n(row, length, value);
      }
    }
  }
}

template <class Visit>
void for_each_leaf(const MaskTree& tree, Visit&& visit) {
  mask_tree_detail::visit_cube(tree, tree.rank_count() - 1, tree.root(), 0, visit);
}

}  // namespace octavo
