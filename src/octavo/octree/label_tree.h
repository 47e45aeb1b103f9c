// A label map in memory: the tree of a mask, with a label for every uniform child and a palette for
// every word of several labels.
//
// Words, cubes, ranks and codes are those of octree/mask_tree.h. A child is uniform when all its
// voxels have one label, 0 (background) like any other; otherwise it is mixed and stored. Along the
// uniform children of a cube, in o-code order, labels come in runs: `starts` marks the first child
// of each, so that the label of a child is found by counting the starts up to it:
//
//     cube     mixed  ..1.....    starts  10..1.1.    first value --.
//     labels of the children  5 5 - 5 0 0 5 5                       '-> 5 0 5 (values of its rank)
//
// A mixed word has 2..64 labels: its palette. The place of a voxel's label in the palette is a
// number of 1..6 bits; bit p of all 64 numbers is one 64-bit word, plane p, so that the voxels of
// a label are had by joining planes, 64 at a time. Plane 0 of all words stand side by side; plane
// p + 1 of those words that have one do, at the place found by counting them before it:
//
//     palette   {0,5} {0,5} {0,3,5} {3,5} {0,2,3,5,8}     each palette is stored once in the tree
//     plane 0    w0    w1     w2     w3       w4
//     deeper 0    0     0      1      0        1          words of more than 2 labels
//     plane 1                 w2              w4
//     deeper 1                 0               1          words of more than 4
//     plane 2                                 w4
//
// Invariants
//   `labels` ascend; each is that of some voxel of the root cube. Outside `size` all voxels are 0.
//   Palettes ascend by their number of labels and then by their labels, which ascend; each is that
//   of some word, and every label of a word's palette is that of one of its voxels.
//   No two runs of a cube that follow each other have the same label.
//   Below the root no stored cube is uniform. Children, values and words of a rank stand in o-code
//   order.
//   deeper[p] has a bit for each word of plane p, or none when there is no plane p + 1.
//   Numbers are held in as few bytes as the largest of their array needs.
// Consequences
//   One map has one tree: equal maps have equal arrays.
//   A sub-tree is one contiguous run of every array below it.
//   A voxel is reached in one step per rank, and one for every doubling of the labels in its word.
//   The mask of a label is made word by word, and so is a count or a sum over its voxels.
//   Memory goes with the surfaces between labels: 32 bytes per mixed cube and a few for its runs,
//   8 bytes per plane of a mixed word and 0 to 4 for the number of its palette. A map of two labels
//   takes little more than a mask, whatever the two are.
//   The condensed leaves are a view of it (`for_each_leaf`, `to_linear_octree`).
//
// Source  thesis 1.2, 2.3
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/octree/linear_octree.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/octree/packed_numbers.h"
#include "octavo/octree/ranked_bits.h"

namespace octavo {

/// Which of 64 children are stored, from `first` of the array below on; and where the labels of the
/// others change, from `first_value` of the values of its rank on.
struct LabelCube {
  std::uint64_t mixed = 0;
  std::uint64_t starts = 0;
  std::uint64_t first = 0;
  std::uint64_t first_value = 0;

  bool operator==(const LabelCube&) const = default;
  bool is_uniform() const noexcept { return mixed == 0 && std::has_single_bit(starts); }
  /// Behind the last stored child.
  std::uint64_t end() const noexcept {
    return first + static_cast<std::uint64_t>(std::popcount(mixed));
  }
  /// Behind the last of its values.
  std::uint64_t end_value() const noexcept {
    return first_value + static_cast<std::uint64_t>(std::popcount(starts));
  }
  /// The place of the stored child at `bit`. Requires that it is mixed.
  std::uint64_t place_of(int bit) const noexcept {
    const std::uint64_t before = mixed & ((std::uint64_t{1} << bit) - 1);
    return first + static_cast<std::uint64_t>(std::popcount(before));
  }
  /// The place of the value of the child at `bit`. Requires that it is uniform.
  std::uint64_t value_of(int bit) const noexcept {
    const std::uint64_t until = starts & ((std::uint64_t{2} << bit) - 1);
    return first_value + static_cast<std::uint64_t>(std::popcount(until)) - 1;
  }
};

inline constexpr int kMostLabelPlanes = 6;

/// Planes of a word with so many labels, 2..64.
constexpr int label_planes(std::uint64_t label_count) noexcept {
  return static_cast<int>(std::bit_width(label_count - 1));
}

/// The arrays of a tree. A label is meant by its place in `labels`, a palette by its number.
struct LabelArrays {
  std::vector<std::int64_t> labels;
  std::vector<std::vector<LabelCube>> cubes;  ///< by rank
  std::vector<PackedNumbers> values;          ///< by rank: the labels of the runs of its cubes
  PackedNumbers palettes;                     ///< of each word
  std::array<std::vector<std::uint64_t>, kMostLabelPlanes> planes;
  std::array<RankedBits, kMostLabelPlanes - 1> deeper;
  std::vector<std::uint64_t> palette_starts;  ///< in palette_labels, and the end of the last
  PackedNumbers palette_labels;

  bool operator==(const LabelArrays&) const = default;
};

/// Bytes of the arrays.
std::uint64_t memory_bytes(const LabelArrays& arrays) noexcept;

class LabelTree {
 public:
  /// A volume of `size` whose voxels are all 0. Throws Error{limit_exceeded} on a bad size.
  explicit LabelTree(const Size3& size = {1, 1, 1});

  /// The tree made of `arrays`, whose last rank holds the root alone.
  /// Requires the invariants above (`is_valid` proves them).
  LabelTree(const Size3& size, LabelArrays arrays);

  const Size3& size() const { return size_; }
  int rank_count() const { return static_cast<int>(arrays_.cubes.size()); }
  const LabelArrays& arrays() const { return arrays_; }
  std::span<const LabelCube> cubes(int rank) const {
    return arrays_.cubes[static_cast<std::size_t>(rank)];
  }
  const LabelCube& root() const { return arrays_.cubes.back().front(); }
  bool operator==(const LabelTree&) const = default;

  /// Ascending: those of all voxels, and 0 where the root cube is larger than the volume.
  std::span<const std::int64_t> labels() const { return arrays_.labels; }
  std::uint64_t word_count() const { return arrays_.planes[0].size(); }
  std::uint64_t palette_count() const { return arrays_.palette_starts.size() - 1; }

  /// The label of a voxel; 0 outside the volume. O(ranks), thread-safe.
  std::int64_t label_at(const Index3& voxel) const noexcept;

  /// The labels of a palette, as places in `labels()`.
  std::uint32_t palette_of(std::uint64_t word) const noexcept { return arrays_.palettes[word]; }
  std::uint64_t palette_size(std::uint32_t palette) const noexcept {
    return arrays_.palette_starts[palette + std::size_t{1}] - arrays_.palette_starts[palette];
  }
  std::uint32_t palette_label(std::uint32_t palette, std::uint64_t entry) const noexcept {
    return arrays_.palette_labels[arrays_.palette_starts[palette] + entry];
  }

  /// The planes of a word; those that it does not have are 0.
  std::array<std::uint64_t, kMostLabelPlanes> planes_of(std::uint64_t word) const noexcept;

  /// The voxels of a word that have the label at `entry` of its palette.
  /// planes  of the word
  static std::uint64_t bits_of(const std::array<std::uint64_t, kMostLabelPlanes>& planes,
                               std::uint64_t palette_size, std::uint64_t entry) noexcept {
    std::uint64_t bits = kFullWord;
    for (int p = 0; p < label_planes(palette_size); ++p) {
      const std::uint64_t plane = planes[static_cast<std::size_t>(p)];
      bits &= (entry >> p & 1) != 0 ? plane : ~plane;
    }
    return bits;
  }

  /// The label of a uniform child, as a place in `labels()`.
  std::uint32_t label_of_child(int rank, const LabelCube& cube, int bit) const noexcept {
    return arrays_.values[static_cast<std::size_t>(rank)][cube.value_of(bit)];
  }

  /// Calls visit(place in `labels()`, bits) for each label of a stored word, ascending.
  template <class Visit>
  void visit_word(std::uint64_t word, Visit&& visit) const;

  /// Calls visit(place in `labels()`, bits) for each run of uniform children of a cube.
  template <class Visit>
  void visit_runs(int rank, const LabelCube& cube, Visit&& visit) const;

  /// Bytes of the arrays.
  std::uint64_t memory_bytes() const noexcept { return octavo::memory_bytes(arrays_); }

 private:
  Size3 size_;
  LabelArrays arrays_;
};

/// True when the invariants of a tree hold. O(size of the tree)
bool is_valid(const LabelTree& tree);

/// The voxels of each of `tree.labels()`; of 0 those inside the volume. O(size of the tree)
std::vector<std::uint64_t> voxel_counts(const LabelTree& tree);

/// Leaves of each level of the condensed octree, level 0 (voxels) first, up to the root's level n.
std::vector<std::int64_t> leaf_counts(const LabelTree& tree);

/// The leaves of all labels but 0 as sorted lists of codes with their labels: what `condense` makes
/// of the voxels. Memory 16 bytes per leaf.
LinearOctree to_linear_octree(const LabelTree& tree);

/// Calls visit(OCode, place in `labels()`) for every leaf of the condensed octree whose label is
/// not 0, sub-octree by sub-octree in o-code order.
template <class Visit>
void for_each_leaf(const LabelTree& tree, Visit&& visit);

/// Writes the label of every voxel of `box` to `voxels`, [z][y][x] without gaps. Thread-safe.
/// T  an integer voxel type, or int64_t; labels that do not fit are cut
/// Requires a box inside the volume
template <class T>
void fill_voxels(const LabelTree& tree, const Box& box, T* voxels);

// ---- implementation of the templates

template <class Visit>
void LabelTree::visit_word(std::uint64_t word, Visit&& visit) const {
  const std::uint32_t palette = palette_of(word);
  const std::uint64_t count = palette_size(palette);
  const auto planes = planes_of(word);
  for (std::uint64_t entry = 0; entry < count; ++entry) {
    visit(palette_label(palette, entry), bits_of(planes, count, entry));
  }
}

template <class Visit>
void LabelTree::visit_runs(int rank, const LabelCube& cube, Visit&& visit) const {
  std::uint64_t place = cube.first_value;
  for (std::uint64_t left = cube.starts; left != 0;) {
    const std::uint64_t from = ~((left & -left) - 1);
    left &= left - 1;
    const std::uint64_t until = (left & -left) - 1;  // all bits after the last start
    visit(arrays_.values[static_cast<std::size_t>(rank)][place++], from & until & ~cube.mixed);
  }
}

namespace label_tree_detail {

template <class Visit>
class LeafWalk {
 public:
  LeafWalk(const LabelTree& tree, Visit& visit) : tree_(tree), visit_(visit) {}

  void walk_cube(int rank, const LabelCube& cube, std::uint64_t code) {
    const int level = 2 * (rank + 1);  // of the children
    if (cube.is_uniform()) {
      emit({level + 2, code}, tree_.label_of_child(rank, cube, 0));
      return;
    }
    std::uint64_t child = cube.first;
    for (int octant = 0; octant < 8; ++octant) {
      const std::uint64_t mixed = cube.mixed >> 8 * octant & 0xff;
      const std::uint64_t starts = cube.starts >> 8 * octant & 0xff;
      // One run goes through an octant in which none starts but at its first child.
      if (mixed == 0 && (starts & 0xfe) == 0) {
        emit({level + 1, code << 3 | static_cast<std::uint64_t>(octant)},
             tree_.label_of_child(rank, cube, 8 * octant));
        continue;
      }
      for (int bit = 8 * octant; bit < 8 * octant + 8; ++bit) {
        const std::uint64_t below = code << 6 | static_cast<std::uint64_t>(bit);
        if ((cube.mixed >> bit & 1) == 0) {
          emit({level, below}, tree_.label_of_child(rank, cube, bit));
        } else if (rank == 0) {
          walk_word(child++, below);
        } else {
          walk_cube(rank - 1, tree_.cubes(rank - 1)[child++], below);
        }
      }
    }
  }

 private:
  void emit(const OCode& leaf, std::uint32_t label) {
    if (tree_.labels()[label] != 0) visit_(leaf, label);
  }

  void walk_word(std::uint64_t word, std::uint64_t code) {
    std::array<std::uint32_t, 64> labels;
    tree_.visit_word(word, [&](std::uint32_t label, std::uint64_t bits) {
      for (; bits != 0; bits &= bits - 1) {
        labels[static_cast<std::size_t>(std::countr_zero(bits))] = label;
      }
    });
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const std::uint32_t* const voxel = labels.data() + 8 * octant;
      const std::uint64_t below = code << 3 | octant;
      if (std::all_of(voxel + 1, voxel + 8, [&](std::uint32_t l) { return l == *voxel; })) {
        emit({1, below}, *voxel);
        continue;
      }
      for (std::uint64_t i = 0; i < 8; ++i) emit({0, below << 3 | i}, voxel[i]);
    }
  }

  const LabelTree& tree_;
  Visit& visit_;
};

}  // namespace label_tree_detail

template <class Visit>
void for_each_leaf(const LabelTree& tree, Visit&& visit) {
  label_tree_detail::LeafWalk walk(tree, visit);
  walk.walk_cube(tree.rank_count() - 1, tree.root(), 0);
}

}  // namespace octavo
