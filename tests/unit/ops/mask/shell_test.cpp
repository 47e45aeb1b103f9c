#include "octavo/ops/mask/shell.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <random>

#include "octavo/octree/linear_octree.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

/// Whether a leaf of the cube's size or larger covers it: its code is cut level by level and looked
/// for in the list of each.
bool is_covered(const LinearOctree& octree, const OCode& cube) {
  for (int level = cube.level; level <= octree.root_level; ++level) {
    const auto& codes = octree.levels[static_cast<std::size_t>(level)].codes;
    if (std::binary_search(codes.begin(), codes.end(), ancestor_of(cube, level).code)) return true;
  }
  return false;
}

bool is_hidden(const LinearOctree& octree, const OCode& leaf) {
  for (std::size_t face = 0; face < 6; ++face) {
    const auto beside = neighbor_of(leaf, kDirections[face], octree.root_level);
    if (!beside || !is_covered(octree, *beside)) return false;
  }
  return true;
}

LinearOctree shell_by_search(const LinearOctree& octree) {
  LinearOctree kept = empty_octree(octree.root_level);
  for (int level = 0; level <= octree.root_level; ++level) {
    const auto l = static_cast<std::size_t>(level);
    for (const std::uint64_t code : octree.levels[l].codes) {
      if (is_hidden(octree, {level, code})) continue;
      kept.levels[l].codes.push_back(code);
      kept.levels[l].values.push_back(1);
    }
  }
  return kept;
}

/// Large blocks with rough borders: hidden leaves of several levels.
DenseMask rough_block(const Size3& size, std::mt19937& random) {
  DenseMask mask = testing::random_mask(size, random);
  testing::for_each_voxel(size, [&](const Index3& p) {
    const bool is_inner = p.x > 2 && p.y > 1 && p.z > 3 && p.x < size.x - 2 && p.y < size.y - 5;
    if (is_inner && random() % 4000 != 0) mask.at(p) = 1;
  });
  return mask;
}

TEST(Shell, LeavesOutWhatSearchingTheLevelListsFindsCovered) {
  std::mt19937 random(4);
  for (const Size3& size : testing::odd_sizes()) {
    for (const DenseMask& dense :
         {testing::random_mask(size, random), rough_block(size, random)}) {
      const MaskTree mask = testing::tree_of(dense);
      const MaskTree made = shell(mask);
      ASSERT_TRUE(is_valid(made));
      ASSERT_EQ(to_linear_octree(made), shell_by_search(to_linear_octree(mask)));
    }
  }
}

TEST(Shell, DoesNotDependOnThreads) {
  std::mt19937 random(5);
  const MaskTree mask = testing::tree_of(rough_block({150, 140, 130}, random));
  MaskTree one;
  tbb::task_arena(1).execute([&] { one = shell(mask); });
  EXPECT_LT(leaf_count(one), leaf_count(mask));
  for (const int threads : {2, 5}) {
    MaskTree many;
    tbb::task_arena(threads).execute([&] { many = shell(mask); });
    EXPECT_EQ(many, one);
  }
}

TEST(Shell, KeepsWhatTouchesTheBorderOfTheVolume) {
  for (const Size3& size : {Size3{64, 64, 64}, Size3{256, 256, 256}, Size3{65, 64, 3}}) {
    const MaskTree whole = box_mask(size, box_of(size));
    const MaskTree made = shell(whole);
    ASSERT_TRUE(is_valid(made));
    EXPECT_EQ(to_linear_octree(made), shell_by_search(to_linear_octree(whole)));
  }
  EXPECT_TRUE(shell(MaskTree({70, 70, 70})).is_empty());
}

TEST(LeafCount, IsThatOfTheLinearOctree) {
  std::mt19937 random(6);
  for (const Size3& size : testing::odd_sizes()) {
    const MaskTree mask = testing::tree_of(testing::random_mask(size, random));
    EXPECT_EQ(leaf_count(mask), leaf_count(to_linear_octree(mask)));
  }
}

TEST(BoundingBox, HoldsEveryVoxelAndNoPlaneTooMuch) {
  std::mt19937 random(7);
  for (int round = 0; round < 4; ++round) {
    for (const Size3& size : testing::odd_sizes()) {
      DenseMask dense = testing::random_mask(size, random);
      const auto wall = static_cast<std::int64_t>(random() % 9);
      Box expected{{size.x, size.y, size.z}, {0, 0, 0}};
      testing::for_each_voxel(size, [&](const Index3& p) {
        if (p.x < wall || p.y < wall / 2) dense.at(p) = 0;
        if (dense.at(p) == 0) return;
        for (int axis = 0; axis < 3; ++axis) {
          expected.lo[axis] = std::min(expected.lo[axis], p[axis]);
          expected.hi[axis] = std::max(expected.hi[axis], p[axis] + 1);
        }
      });
      if (expected.is_empty()) expected = Box{};
      EXPECT_EQ(bounding_box(testing::tree_of(dense)), expected);
    }
  }
}

}  // namespace
}  // namespace octavo
