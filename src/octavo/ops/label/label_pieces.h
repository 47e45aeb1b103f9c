// Label trees made in pieces: cubes of 64^3 on many threads, put together in o-code order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/octree/label_tree.h"

namespace octavo {

/// The voxels of a word that have a label.
struct LabelBits {
  std::int64_t label = 0;
  std::uint64_t bits = 0;
};

/// A cube of 64^3 voxels, as the arrays of a tree that is no larger.
struct LabelPart {
  std::uint64_t code = 0;  ///< its place among the cubes of its rank
  LabelArrays arrays;
};

/// Different palettes, numbered as they come.
class PaletteTable {
 public:
  void clear();

  /// The number of the palette with these labels, which ascend.
  /// Throws Error{limit_exceeded} above 2^32 - 2 palettes
  std::uint32_t number_of(std::span<const std::int64_t> labels);

  std::uint32_t count() const { return static_cast<std::uint32_t>(starts_.size() - 1); }
  std::span<const std::int64_t> labels(std::uint32_t palette) const {
    return std::span(labels_).subspan(starts_[palette], starts_[palette + 1] - starts_[palette]);
  }
  /// The labels of all palettes, one after the other.
  std::span<const std::int64_t> all_labels() const { return labels_; }

  /// The numbers in the order of a tree.
  std::vector<std::uint32_t> in_order() const;

 private:
  std::size_t slot_of(std::span<const std::int64_t> labels) const;
  void grow();

  std::vector<std::int64_t> labels_;
  std::vector<std::size_t> starts_ = {0};
  std::vector<std::uint32_t> slots_;  // number + 1, 0: free; a power of two of them
  std::uint32_t last_ = 0;
};

/// Makes the children of a cube that are uniform into runs.
/// Label  the label itself, or its place among others
template <class Label>
class LabelRuns {
 public:
  /// The next child; bits ascend.
  void add_uniform(int bit, Label label) {
    if (count_ == 0 || labels_[count_ - 1] != label) {
      labels_[count_++] = label;
      cube_.starts |= std::uint64_t{1} << bit;
    }
  }
  void add_mixed(int bit) { cube_.mixed |= std::uint64_t{1} << bit; }

  /// The cube; where its children and values begin is left to the caller.
  const LabelCube& cube() const { return cube_; }
  std::span<const Label> labels() const { return std::span(labels_).first(count_); }

 private:
  LabelCube cube_;
  std::size_t count_ = 0;
  std::array<Label, 64> labels_;
};

/// Makes cubes of 64^3 voxels, of their 4096 words in o-code order each.
class LabelFold {
 public:
  /// The next word, of one label.
  void add_uniform(std::int64_t label) {
    runs_.add_uniform(bit_, label);
    advance();
  }

  /// The next word, of 2 to 64 labels in any order, which are sorted; their bits are all 64.
  void add_mixed(std::span<LabelBits> labels);

  /// The cube, after its last word; words of the next one may follow.
  LabelArrays finish();

 private:
  void advance();

  int bit_ = 0;  // of the next word in its cube of 16^3
  int cube_bit_ = 0;
  std::uint64_t first_word_ = 0;
  LabelRuns<std::int64_t> runs_;
  LabelRuns<std::int64_t> root_;
  std::vector<LabelCube> cubes_;
  std::vector<std::int64_t> values_;  // of cubes_
  std::vector<std::uint32_t> palette_of_;
  std::array<std::vector<std::uint64_t>, kMostLabelPlanes> planes_;
  PaletteTable palettes_;
};

/// The tree of cubes of 64^3 in ascending order of codes; all that they do not hold is 0. They are
/// emptied one by one, so that memory stays near that of the tree.
/// Requires that all voxels outside `size` are 0.
/// Throws Error{limit_exceeded} on a bad size, and as PaletteTable
LabelTree join_labels(const Size3& size, std::vector<LabelPart> parts);

}  // namespace octavo
