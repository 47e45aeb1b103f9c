// Mask trees and label trees by one set of names: the children of a cube, the labels of a word, and
// the cubes of 64^3 voxels that bricks lie in.
//
// A mask has the labels 0 and 1. A label is meant by its place in `labels_of(tree)`.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "octavo/octree/label_tree.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// What one of the 64 children of a cube is.
struct TreeChild {
  bool is_stored = false;
  /// Its place in the array below when it is stored; otherwise that of its label.
  std::uint64_t place = 0;
};

inline std::span<const std::int64_t> labels_of(const MaskTree&) noexcept {
  static constexpr std::array<std::int64_t, 2> kLabels = {0, 1};
  return kLabels;
}
inline std::span<const std::int64_t> labels_of(const LabelTree& tree) noexcept {
  return tree.labels();
}

/// The child at `bit` of the cube at `place` of a rank.
inline TreeChild child_at(const MaskTree& tree, int rank, std::uint64_t place, int bit) noexcept {
  const MaskCube& cube = tree.cubes(rank)[place];
  if ((cube.mixed >> bit & 1) != 0) return {true, cube.place_of(bit)};
  return {false, cube.full >> bit & 1};
}
inline TreeChild child_at(const LabelTree& tree, int rank, std::uint64_t place, int bit) noexcept {
  const LabelCube& cube = tree.cubes(rank)[place];
  if ((cube.mixed >> bit & 1) != 0) return {true, cube.place_of(bit)};
  return {false, tree.label_of_child(rank, cube, bit)};
}

/// Calls visit(place of a label, bits) for each label of a stored word, ascending.
template <class Visit>
void visit_word(const MaskTree& tree, std::uint64_t word, Visit&& visit) {
  const std::uint64_t bits = tree.words()[word];
  visit(std::uint32_t{0}, ~bits);
  visit(std::uint32_t{1}, bits);
}
template <class Visit>
void visit_word(const LabelTree& tree, std::uint64_t word, Visit&& visit) {
  tree.visit_word(word, visit);
}

/// The rank of cubes of 64^3 voxels, and their side.
inline constexpr int kCellRank = 1;
inline constexpr std::int64_t kCellSide = child_side(kCellRank + 1);

/// The cell at `corner`, multiples of 64: stored, or part of a larger cube of one label.
template <class Tree>
TreeChild cell_at(const Tree& tree, const Index3& corner) noexcept;

/// Divides the cells that meet a box of the volume: uniform(box, place of its label) is called for
/// cubes of cells of one label, clipped to `box`, and stored(place, corner) for each stored cell.
/// A cube of any size that has one label costs one step.
template <class Tree, class Uniform, class Stored>
void visit_tree_cells(const Tree& tree, const Box& box, Uniform&& uniform, Stored&& stored);

// ---- implementation of the templates

template <class Tree>
TreeChild cell_at(const Tree& tree, const Index3& corner) noexcept {
  const std::uint64_t code = interleave(corner);
  TreeChild cube{true, 0};
  for (int rank = tree.rank_count() - 1; rank > kCellRank && cube.is_stored; --rank) {
    cube = child_at(tree, rank, cube.place, static_cast<int>(code >> 6 * (rank + 1) & 63));
  }
  return cube;
}

namespace tree_child_detail {

template <class Tree, class Uniform, class Stored>
void visit_cube(const Tree& tree, const Box& box, int rank, std::uint64_t place,
                const Index3& corner, Uniform& uniform, Stored& stored) {
  if (rank == kCellRank) {
    stored(place, corner);
    return;
  }
  for (int bit = 0; bit < 64; ++bit) {
    const Box part = child_box(corner, bit, child_side(rank));
    const Box inside = intersection(part, box);
    if (inside.is_empty()) continue;
    const TreeChild child = child_at(tree, rank, place, bit);
    if (child.is_stored) {
      visit_cube(tree, box, rank - 1, child.place, part.lo, uniform, stored);
    } else {
      uniform(inside, static_cast<std::uint32_t>(child.place));
    }
  }
}

}  // namespace tree_child_detail

template <class Tree, class Uniform, class Stored>
void visit_tree_cells(const Tree& tree, const Box& box, Uniform&& uniform, Stored&& stored) {
  tree_child_detail::visit_cube(tree, box, tree.rank_count() - 1, 0, {0, 0, 0}, uniform, stored);
}

}  // namespace octavo
