// What each label has of the cubes of a label tree, as the masks of them would hold it.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/octree/label_tree.h"

namespace octavo {

/// What a label has in a cube of 16^3 voxels: which of its words are full, and the others that are
/// not empty.
struct LabelPortion {
  std::uint32_t label = 0;  ///< place in the labels of the tree
  std::uint64_t full = 0;
  std::uint64_t mixed = 0;
  std::vector<std::uint64_t> words;  ///< one for each bit of `mixed`
};

/// Divides cubes among labels, one after the other. One thread at a time.
/// Memory  4 bytes per label of the tree, and the portions of a cube
class LabelPortions {
 public:
  explicit LabelPortions(const LabelTree& tree) : tree_(tree), slots_(tree.labels().size(), kNone) {
    const auto zero = std::ranges::find(tree.labels(), 0);
    if (zero != tree.labels().end()) {
      background_ = static_cast<std::uint32_t>(zero - tree.labels().begin());
    }
  }

  /// The portions in the stored cube of rank 0 at `place`; valid until the next call. Every label
  /// in the cube but 0 has one, in no order.
  std::span<const LabelPortion> in_cube(std::uint64_t place) {
    for (std::size_t i = 0; i < count_; ++i) slots_[portions_[i].label] = kNone;
    count_ = 0;
    const LabelCube& cube = tree_.cubes(0)[place];
    tree_.visit_runs(0, cube, [&](std::uint32_t label, std::uint64_t bits) {
      if (label != background_) portion_of(label).full |= bits;
    });
    std::uint64_t word = cube.first;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const std::uint64_t here = left & -left;
      tree_.visit_word(word++, [&](std::uint32_t label, std::uint64_t bits) {
        if (label == background_) return;
        LabelPortion& portion = portion_of(label);
        portion.mixed |= here;
        portion.words.push_back(bits);
      });
    }
    return std::span(portions_).first(count_);
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  LabelPortion& portion_of(std::uint32_t label) {
    std::uint32_t& slot = slots_[label];
    if (slot == kNone) {
      slot = static_cast<std::uint32_t>(count_++);
      if (slot == portions_.size()) portions_.emplace_back();
      portions_[slot].label = label;
      portions_[slot].full = 0;
      portions_[slot].mixed = 0;
      portions_[slot].words.clear();
    }
    return portions_[slot];
  }

  const LabelTree& tree_;
  std::uint32_t background_ = kNone;
  std::vector<std::uint32_t> slots_;  // by label
  std::vector<LabelPortion> portions_;
  std::size_t count_ = 0;
};

/// A stored cube of 64^3 voxels of a tree.
struct LabelPlace {
  std::uint64_t code = 0;  ///< among the cubes of its rank
  std::uint64_t place = 0;
};

/// The stored cubes of 64^3 in o-code order, at which work on a tree is split. Above them,
/// take(rank, code of a cube, place in the labels, bits) is called for each run of its children.
template <class Take>
std::vector<LabelPlace> label_places(const LabelTree& tree, Take&& take);

// ---- implementation of the template

namespace label_portions_detail {

template <class Take>
void collect(const LabelTree& tree, int rank, const LabelPlace& at, Take& take,
             std::vector<LabelPlace>& places) {
  if (rank == 1) {
    places.push_back(at);
    return;
  }
  const LabelCube& cube = tree.cubes(rank)[at.place];
  tree.visit_runs(rank, cube, [&](std::uint32_t label, std::uint64_t bits) {
    take(rank, at.code, label, bits);
  });
  for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
    const int bit = std::countr_zero(left);
    const std::uint64_t code = at.code << 6 | static_cast<std::uint64_t>(bit);
    collect(tree, rank - 1, {code, cube.place_of(bit)}, take, places);
  }
}

}  // namespace label_portions_detail

template <class Take>
std::vector<LabelPlace> label_places(const LabelTree& tree, Take&& take) {
  std::vector<LabelPlace> places;
  label_portions_detail::collect(tree, tree.rank_count() - 1, {0, 0}, take, places);
  return places;
}

}  // namespace octavo
