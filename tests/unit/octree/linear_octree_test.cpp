#include "octavo/octree/linear_octree.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

// A universe of side 4: one cube of side 2 and two voxels.
LinearOctree small_octree() {
  LinearOctree octree = empty_octree(2);
  octree.levels[0] = {{010, 017}, {5, 6}};
  octree.levels[1] = {{02}, {7}};
  return octree;
}

TEST(LinearOctree, VolumeIsTheSumOverTheLevels) {
  const LinearOctree octree = small_octree();
  EXPECT_EQ(leaf_count(octree), 3);
  EXPECT_EQ(leaf_count(octree, 0), 2);
  EXPECT_EQ(leaf_volume(octree), 10u);
  EXPECT_TRUE(is_linear(octree));
  EXPECT_TRUE(is_complete(octree, 10));
  EXPECT_FALSE(is_complete(octree, 11));
}

TEST(LinearOctree, UnsortedListsAreFound) {
  LinearOctree swapped = small_octree();
  std::swap(swapped.levels[0].codes[0], swapped.levels[0].codes[1]);
  EXPECT_FALSE(is_sorted(swapped));
  LinearOctree twice = small_octree();
  twice.levels[0].codes[1] = twice.levels[0].codes[0];
  EXPECT_FALSE(is_sorted(twice));
  LinearOctree outside = small_octree();
  outside.levels[1].codes[0] = 8;
  EXPECT_FALSE(is_sorted(outside));
  LinearOctree short_values = small_octree();
  short_values.levels[0].values.pop_back();
  EXPECT_FALSE(is_sorted(short_values));
  LinearOctree missing_level = small_octree();
  missing_level.levels.pop_back();
  EXPECT_FALSE(is_sorted(missing_level));
  for (const int level : {-1, kMaxUniverseLevel + 1}) {
    LinearOctree elsewhere;
    elsewhere.root_level = level;
    elsewhere.levels.resize(static_cast<std::size_t>(level + 1));
    EXPECT_FALSE(is_sorted(elsewhere));
    EXPECT_FALSE(is_linear(elsewhere));
  }
}

TEST(LinearOctree, ALeafInsideAnotherIsFound) {
  for (const std::uint64_t code : {020u, 023u, 027u}) {
    LinearOctree octree = small_octree();
    octree.levels[0] = {{code}, {1}};
    EXPECT_TRUE(is_sorted(octree));
    EXPECT_FALSE(is_linear(octree)) << code;
    EXPECT_FALSE(is_complete(octree, leaf_volume(octree)));
  }
  LinearOctree under_root = small_octree();
  under_root.levels[2] = {{0}, {1}};
  EXPECT_FALSE(is_linear(under_root));
}

TEST(LinearOctree, TheLeafOverAVoxelIsTheOneThatContainsIt) {
  const LinearOctree octree = small_octree();
  EXPECT_EQ(find_leaf(octree, {3, 1, 1}), (Leaf{{1, 02}, 7}));
  EXPECT_EQ(find_leaf(octree, deinterleave(017)), (Leaf{{0, 017}, 6}));
  EXPECT_FALSE(find_leaf(octree, {0, 0, 0}));
  EXPECT_FALSE(find_leaf(octree, {4, 0, 0}));
  EXPECT_FALSE(find_leaf(octree, {-1, 0, 0}));
}

}  // namespace
}  // namespace octavo
