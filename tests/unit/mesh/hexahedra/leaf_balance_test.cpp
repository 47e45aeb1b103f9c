#include "octavo/mesh/hexahedra/leaf_balance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "hex_samples.h"

namespace octavo {
namespace {

using testing::DenseLabels;

/// The state of every cell of every level, all of them looked at.
class DenseBalance {
 public:
  enum State : std::uint8_t { empty, full, split };

  DenseBalance(const LabelTree& tree, const DenseLabels& labels) {
    while ((std::int64_t{1} << top_) < std::max({labels.size.x, labels.size.y, labels.size.z})) {
      ++top_;
    }
    top_ = std::max(top_, 4);
    for (int level = 0; level <= top_; ++level) {
      cells_.emplace_back(static_cast<std::size_t>(1) << 3 * (top_ - level), empty);
    }
    for_each_leaf(tree, [&](const OCode& leaf, auto) { add(leaf); });
    for (int level = 1; level < top_; ++level) split_neighbors(level);
  }

  std::vector<OCode> leaves() const {
    std::vector<OCode> all;
    add_leaves({top_, 0}, all);
    return all;
  }

 private:
  std::uint8_t& state(const OCode& cube) {
    return cells_[static_cast<std::size_t>(cube.level)][cube.code];
  }

  void add(const OCode& leaf) {
    for (int level = 0; level <= leaf.level; ++level) {
      const int shift = 3 * (leaf.level - level);
      for (std::uint64_t i = 0; i < std::uint64_t{1} << shift; ++i) {
        state({level, leaf.code << shift | i}) = full;
      }
    }
    for (int level = leaf.level + 1; level <= top_; ++level) {
      state(ancestor_of(leaf, level)) = split;
    }
  }

  void split_neighbors(int level) {
    for (std::uint64_t code = 0; code < cells_[static_cast<std::size_t>(level)].size(); ++code) {
      if (state({level, code}) != split) continue;
      for (const auto& beside : neighbors_of({level, code}, top_)) {
        if (!beside || state(parent_of(*beside)) != full) continue;
        for (int above = level + 1; above <= top_; ++above) {
          state(ancestor_of(*beside, above)) = split;
        }
      }
    }
  }

  void add_leaves(const OCode& cube, std::vector<OCode>& all) const {
    const std::uint8_t state = cells_[static_cast<std::size_t>(cube.level)][cube.code];
    if (state == full) all.push_back(cube);
    if (state != split) return;
    for (const OCode& child : children_of(cube)) add_leaves(child, all);
  }

  int top_ = 0;
  std::vector<std::vector<std::uint8_t>> cells_;
};

std::vector<OCode> balanced(const LabelTree& tree) {
  LeafBalance balance;
  for_each_leaf(tree, [&](const OCode& leaf, auto) { balance.add(leaf); });
  return balance.finish();
}

std::uint64_t voxels_of(const std::vector<OCode>& leaves) {
  std::uint64_t count = 0;
  for (const OCode& leaf : leaves) count += cube_volume(leaf.level);
  return count;
}

/// Pairs of leaves that touch and differ by more than one level.
std::size_t steep_pairs(const std::vector<OCode>& leaves) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Box a = box_of(leaves[i]);
    for (std::size_t k = 0; k < i; ++k) {
      if (std::abs(leaves[i].level - leaves[k].level) < 2) continue;
      const Box b = box_of(leaves[k]);
      bool touch = true;
      for (int axis = 0; axis < 3; ++axis) {
        touch = touch && a.lo[axis] <= b.hi[axis] && b.lo[axis] <= a.hi[axis];
      }
      if (touch) ++count;
    }
  }
  return count;
}

TEST(LeafBalance, GivesWhatAllCellsLookedAtGive) {
  std::mt19937 random(11);
  for (int run = 0; run < 60; ++run) {
    const DenseLabels labels = testing::hex_labels(random);
    const LabelTree tree = testing::tree_of(labels);
    EXPECT_EQ(balanced(tree), DenseBalance(tree, labels).leaves()) << "run " << run;
  }
}

TEST(LeafBalance, SolidsBeyondOneBlockAreBalancedAsWell) {
  std::mt19937 random(5);
  for (int run = 0; run < 6; ++run) {
    DenseLabels labels({64, 64, 64}, 1);
    for (int hole = 0; hole <= run; ++hole) {
      const auto at = [&] { return static_cast<std::int64_t>(random() % 64); };
      labels.at({at(), at(), at()}) = run % 2 == 0 ? 0 : 2;
    }
    const LabelTree tree = testing::tree_of(labels);
    const std::vector<OCode> leaves = balanced(tree);
    EXPECT_EQ(leaves, DenseBalance(tree, labels).leaves()) << "run " << run;
    EXPECT_EQ(steep_pairs(leaves), 0u);
  }
}

TEST(LeafBalance, LeavesThatTouchDifferByOneLevelAndFillTheSameVoxels) {
  std::mt19937 random(23);
  for (int run = 0; run < 8; ++run) {
    const DenseLabels labels = testing::random_labels({24, 20, 28}, testing::kHexLabels, random);
    const std::vector<OCode> leaves = balanced(testing::tree_of(labels));
    EXPECT_EQ(steep_pairs(leaves), 0u);
    EXPECT_EQ(voxels_of(leaves),
              static_cast<std::uint64_t>(std::count_if(labels.voxels.begin(), labels.voxels.end(),
                                                       [](auto label) { return label != 0; })));
    EXPECT_TRUE(std::is_sorted(leaves.begin(), leaves.end(), [](const OCode& a, const OCode& b) {
      return a.code << 3 * a.level < b.code << 3 * b.level;
    }));
  }
}

TEST(LeafBalance, ALargeLeafBesideASmallOneIsSplitLevelByLevel) {
  // A cube of 64^3 and one voxel that touches it at a corner, in the next block.
  LeafBalance balance;
  balance.add({6, 0});
  balance.add({0, interleave({64, 64, 64})});
  const std::vector<OCode> leaves = balance.finish();
  std::vector<int> counts(7);
  for (const OCode& leaf : leaves) ++counts[static_cast<std::size_t>(leaf.level)];
  EXPECT_EQ(counts, (std::vector<int>{1, 8, 7, 7, 7, 7, 0}));
}

TEST(LeafBalance, NothingGivesNothing) { EXPECT_TRUE(LeafBalance().finish().empty()); }

}  // namespace
}  // namespace octavo
