#include "octavo/ops/mask/mask_transform.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

/// All 48 turns of a grid.
std::vector<AxisTurn> all_turns() {
  std::vector<AxisTurn> turns;
  std::array<int, 3> from = {0, 1, 2};
  do {
    for (int bits = 0; bits < 8; ++bits) {
      turns.push_back({from, {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0}});
    }
  } while (std::next_permutation(from.begin(), from.end()));
  return turns;
}

DenseMask turned_dense(const DenseMask& mask, const AxisTurn& turn) {
  DenseMask result{turned(mask.size, turn), std::vector<std::uint8_t>(mask.voxels.size())};
  testing::for_each_voxel(result.size, [&](const Index3& p) {
    result.at(p) = mask.at(source_of(p, mask.size, turn));
  });
  return result;
}

DenseMask shifted_dense(const DenseMask& mask, const Index3& by) {
  DenseMask result{mask.size, std::vector<std::uint8_t>(mask.voxels.size())};
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    const Index3 from{p.x - by.x, p.y - by.y, p.z - by.z};
    if (box_of(mask.size).contains(from)) result.at(p) = mask.at(from);
  });
  return result;
}

void expect_shifted(const DenseMask& mask, const MaskTree& tree, const Index3& by) {
  const MaskTree found = shifted(tree, by);
  ASSERT_TRUE(is_valid(found)) << by.x << ' ' << by.y << ' ' << by.z;
  ASSERT_EQ(found, testing::tree_of(shifted_dense(mask, by)))
      << by.x << ' ' << by.y << ' ' << by.z;
}

DenseMask noise(const Size3& size, std::mt19937& random) {
  DenseMask mask = testing::random_mask(size, random);
  for (auto& voxel : mask.voxels) voxel ^= static_cast<std::uint8_t>(random() % 5 == 0);
  return mask;
}

TEST(AxisTurn, QuarterTurnsTakeOneAxisToTheNext) {
  // About z: what lies along x comes to lie along y.
  const Size3 size{7, 5, 3};
  const AxisTurn turn = quarter_turns(2, 1);
  EXPECT_EQ(turned(size, turn), (Size3{5, 7, 3}));
  // The voxel at (6, 0) goes to (4, 6): x 6 becomes y 6, y 0 the far end of x.
  EXPECT_EQ(source_of({4, 6, 1}, size, turn), (Index3{6, 0, 1}));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(quarter_turns(axis, 4), AxisTurn{});
    EXPECT_EQ(quarter_turns(axis, -1), quarter_turns(axis, 3));
    EXPECT_EQ(chained(quarter_turns(axis, 1), quarter_turns(axis, 2)), quarter_turns(axis, 3));
    EXPECT_EQ(chained(mirror_along(axis), mirror_along(axis)), AxisTurn{});
  }
}

TEST(AxisTurn, ChainedIsOneAfterTheOther) {
  const Size3 size{4, 6, 9};
  for (const AxisTurn& first : all_turns()) {
    for (const AxisTurn& second : all_turns()) {
      const Size3 between = turned(size, first);
      const Index3 voxel{1, 2, 3};
      EXPECT_EQ(source_of(voxel, size, chained(first, second)),
                source_of(source_of(voxel, between, second), size, first));
    }
  }
}

Geometry tilted() {
  Geometry geometry;
  geometry.origin_mm = {-40, 12.5, 7};
  geometry.spacing_mm = {0.5, 0.75, 3};
  geometry.direction = {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1};
  return geometry;
}

TEST(AxisTurn, TurnedGeometryKeepsEveryVoxelInItsPlace) {
  const Size3 size{5, 6, 7};
  for (const AxisTurn& turn : all_turns()) {
    const Geometry geometry = turned(tilted(), size, turn);
    for (const Index3& voxel : {Index3{0, 0, 0}, Index3{1, 2, 3}, Index3{4, 1, 4}}) {
      const Index3 source = source_of(voxel, size, turn);
      const auto point = [](const Index3& p) {
        return Point3{static_cast<double>(p.x), static_cast<double>(p.y),
                      static_cast<double>(p.z)};
      };
      const Point3 now = geometry.to_world(point(voxel));
      const Point3 before = tilted().to_world(point(source));
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(now[i], before[i], 1e-12);
    }
  }
}

TEST(AxisTurn, TurnedObjectKeepsDirectionAndCenter) {
  const Size3 size{5, 6, 7};
  for (const AxisTurn& turn : all_turns()) {
    const Geometry geometry = turned_object(tilted(), size, turn);
    EXPECT_EQ(geometry.direction, tilted().direction);
    const Size3 now = turned(size, turn);
    const Point3 center = geometry.to_world({static_cast<double>(now.x - 1) / 2,
                                             static_cast<double>(now.y - 1) / 2,
                                             static_cast<double>(now.z - 1) / 2});
    const Point3 before = tilted().to_world({2, 2.5, 3});
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(center[i], before[i], 1e-12);
      EXPECT_EQ(geometry.spacing_mm[i],
                tilted().spacing_mm[static_cast<std::size_t>(turn.from[i])]);
    }
  }
}

TEST(MaskTurn, IsTheTurnOfEveryVoxel) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    const DenseMask mask = testing::random_mask(size, random);
    const MaskTree tree = testing::tree_of(mask);
    for (const AxisTurn& turn : all_turns()) {
      const MaskTree found = turned(tree, turn);
      ASSERT_TRUE(is_valid(found));
      ASSERT_EQ(found, testing::tree_of(turned_dense(mask, turn)));
    }
  }
}

TEST(MaskTurn, IsTheTurnOfEveryVoxelOfNoise) {
  // Words enough that the work is split.
  std::mt19937 random(2);
  const DenseMask mask = noise({200, 180, 150}, random);
  const MaskTree tree = testing::tree_of(mask);
  for (const AxisTurn& turn : {quarter_turns(0, 1), quarter_turns(2, 3), mirror_along(1)}) {
    const MaskTree found = turned(tree, turn);
    ASSERT_TRUE(is_valid(found));
    ASSERT_EQ(found, testing::tree_of(turned_dense(mask, turn)));
  }
}

TEST(MaskShift, IsTheShiftOfEveryVoxel) {
  std::mt19937 random(3);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 40; ++turn) {
      const DenseMask mask = testing::random_mask(size, random);
      const MaskTree tree = testing::tree_of(mask);
      Index3 by;
      for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t range = 2 * size[axis] + 3;
        by[axis] = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(range)) -
                   size[axis] - 1;
        // Multiples of words and cubes as well.
        if (random() % 3 == 0) by[axis] &= ~std::int64_t{3};
        if (random() % 3 == 0) by[axis] &= ~std::int64_t{15};
      }
      expect_shifted(mask, tree, by);
    }
  }
}

TEST(MaskShift, IsTheShiftOfEveryVoxelOfNoise) {
  std::mt19937 random(4);
  const DenseMask mask = noise({200, 180, 150}, random);
  const MaskTree tree = testing::tree_of(mask);
  for (const Index3& by : {Index3{1, 0, 0}, Index3{-5, 7, 64}, Index3{16, -16, 32},
                           Index3{100, 90, -75}, Index3{0, 0, 149}}) {
    expect_shifted(mask, tree, by);
  }
}

TEST(MaskShift, BringsBackWhatDidNotFallOut) {
  const Box box{{20, 30, 40}, {60, 61, 62}};
  const MaskTree mask = box_mask({100, 100, 100}, box);
  EXPECT_EQ(shifted(shifted(mask, {-13, 5, 37}), {13, -5, -37}), mask);
  EXPECT_TRUE(shifted(mask, {80, 0, 0}).is_empty());
  EXPECT_TRUE(shifted(mask, {std::int64_t{1} << 40, 0, 0}).is_empty());
}

TEST(MaskTransform, DoesNotDependOnTheNumberOfThreads) {
  std::mt19937 random(5);
  const MaskTree mask = testing::tree_of(noise({200, 180, 150}, random));
  MaskTree one;
  MaskTree one_shifted;
  tbb::task_arena(1).execute([&] {
    one = turned(mask, quarter_turns(1, 1));
    one_shifted = shifted(mask, {3, -9, 27});
  });
  tbb::task_arena(4).execute([&] {
    EXPECT_EQ(turned(mask, quarter_turns(1, 1)), one);
    EXPECT_EQ(shifted(mask, {3, -9, 27}), one_shifted);
  });
}

}  // namespace
}  // namespace octavo
