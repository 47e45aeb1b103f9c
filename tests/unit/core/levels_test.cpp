#include "octavo/core/levels.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

using Masks = std::vector<HalvingMask>;

TEST(ChooseHalvings, ThickSlicesWaitUntilTheOthersHaveCaughtUp) {
  EXPECT_EQ(choose_halvings({1, 1, 1}, {1, 1, 1}), Masks{});
  EXPECT_EQ(choose_halvings({5, 4, 3}, {1, 1, 1}), (Masks{7, 7, 7}));
  EXPECT_EQ(choose_halvings({16, 16, 4}, {1, 1, 1.99}), (Masks{7, 7, 7, 7}));
  EXPECT_EQ(choose_halvings({16, 16, 4}, {1, 1, 2}), (Masks{3, 7, 7, 7}));
  EXPECT_EQ(choose_halvings({16, 16, 4}, {1, 1, 4}), (Masks{3, 3, 7, 7}));
  // Not more than four levels, however thick they are.
  EXPECT_EQ(choose_halvings({64, 64, 4}, {1, 1, 1000}), (Masks{3, 3, 3, 3, 7, 7}));
  // An axis of a single voxel is not what others wait for.
  EXPECT_EQ(choose_halvings({1, 4, 4}, {0.1, 1, 1}), (Masks{7, 7}));
}

TEST(Levels, MasksThatLeadAstrayAreCorrupt) {
  const struct {
    const char* what;
    Size3 size;
    Masks masks;
  } cases[] = {
      {"too many", {4, 4, 4}, Masks(kMaxLevels, 7)},
      {"unknown bits", {2, 2, 2}, {8}},
      {"halves nothing", {4, 4, 4}, {7, 0, 7}},
      {"halves a single sample", {1, 1, 1}, {7}},
      {"ends early", {4, 4, 4}, {7}},
      {"ends with one axis long", {4, 4, 4}, {7, 3}},
      {"ends late", {4, 4, 4}, {7, 7, 7}},
      {"bricks of one row", {128, 8, 1}, {1, 1, 1, 1, 1, 1, 7, 2, 2}},
      {"bricks of two rows", {128, 8, 1}, {3, 1, 1, 1, 1, 1, 7, 2}},
  };
  for (const auto& c : cases) {
    try {
      const Levels levels(c.size, c.masks);
      ADD_FAILURE() << c.what;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt) << c.what;
    }
  }
  EXPECT_THROW(Levels({0, 1, 1}, {}), Error);
}

TEST(Levels, ThinBricksAreFineWhereTheVolumeIsThin) {
  const Levels thin({128, 4, 1}, {1, 1, 1, 1, 1, 1, 3, 2});
  EXPECT_EQ(thin.brick_side(0), (Size3{64, 1, 1}));
  EXPECT_EQ(thin.brick_grid(0), (Size3{2, 4, 1}));
  const Levels two({128, 8, 1}, {3, 3, 1, 1, 1, 1, 3});
  EXPECT_EQ(two.brick_side(0), (Size3{64, 4, 1}));
  EXPECT_EQ(two.brick_grid(0), (Size3{2, 2, 1}));
}

TEST(Levels, ACoarseSampleLiesAtTheCenterOfItsVoxels) {
  const Levels levels({16, 16, 4}, {3, 3, 7, 7});
  const Geometry fine{{10, 20, 30}, {0.5, 0.25, 2}, {0, 1, 0, -1, 0, 0, 0, 0, 1}};
  EXPECT_EQ(levels.geometry(fine, 0), fine);
  for (int level = 1; level < levels.count(); ++level) {
    const Geometry coarse = levels.geometry(fine, level);
    Point3 first{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto voxels = static_cast<double>(1 << levels.halving_count(level, axis));
      const auto a = static_cast<std::size_t>(axis);
      EXPECT_EQ(coarse.spacing_mm[a], fine.spacing_mm[a] * voxels);
      first[a] = (voxels - 1) / 2;
    }
    EXPECT_EQ(coarse.origin_mm, fine.to_world(first)) << level;
    EXPECT_EQ(coarse.direction, fine.direction);
  }
  EXPECT_EQ(levels.halving_count(4, 0), 4);
  EXPECT_EQ(levels.halving_count(4, 2), 2);
  EXPECT_EQ(levels.halving(3), 7);
  EXPECT_EQ(levels.halving(4), 0);
}

TEST(Levels, BricksAreClippedAtTheBorder) {
  const Levels levels({100, 64, 65}, choose_halvings({100, 64, 65}, {1, 1, 1}));
  EXPECT_EQ(levels.tier_count(), 2);
  EXPECT_EQ(levels.brick_grid(0), (Size3{2, 1, 2}));
  EXPECT_EQ(levels.brick_box(0, {1, 0, 1}), (Box{{64, 0, 64}, {100, 64, 65}}));
  EXPECT_EQ(levels.brick_count(1), 1);
  EXPECT_EQ(levels.brick_side(1), (Size3{64, 64, 64}));
  const BrickShape shape = brick_shape(levels, 0, {1, 0, 1});
  EXPECT_EQ(shape.size[0], (Size3{36, 64, 1}));
  EXPECT_EQ(shape.size[5], (Size3{2, 2, 1}));
  EXPECT_EQ(shape.halving[5], 7);
}

/// The voxels of level 0 that sample `at` of a level stands for along an axis, counted one by one.
std::int64_t voxels_below(const Levels& levels, int level, int axis, std::int64_t at) {
  std::int64_t count = 0;
  for (std::int64_t v = 0; v < levels.size(0)[axis]; ++v) {
    count += v >> levels.halving_count(level, axis) == at;
  }
  return count;
}

TEST(Levels, SamplesWeighTheVoxelsInside) {
  for (const Size3& size : {Size3{3, 1, 1}, Size3{100, 64, 65}, Size3{67, 5, 130}}) {
    for (const Point3& spacing : {Point3{1, 1, 1}, Point3{1, 1, 5}, Point3{0.4, 1, 0.4}}) {
      const Levels levels(size, choose_halvings(size, spacing));
      for (int level = 0; level < levels.count(); ++level) {
        const int tier = Levels::tier_of(level);
        const Size3 grid = levels.brick_grid(tier);
        const Index3 last{grid.x - 1, grid.y - 1, grid.z - 1};
        const BrickShape shape = brick_shape(levels, tier, last);
        const SampleWeights weights = weights_of(shape, level - shape.first_level);
        for (int axis = 0; axis < 3; ++axis) {
          const std::int64_t end = levels.size(level)[axis] - 1;
          EXPECT_EQ(weights.last[axis], voxels_below(levels, level, axis, end));
          EXPECT_EQ(weights.each[axis], std::int64_t{1} << levels.halving_count(level, axis));
        }
      }
    }
  }
}

TEST(Levels, OnlyTheLastPairOfAnAxisHasTwoWeights) {
  const Levels levels({11, 12, 13}, choose_halvings({11, 12, 13}, {1, 1, 1}));
  const BrickShape shape = brick_shape(levels, 0, {0, 0, 0});
  const SampleWeights voxels = weights_of(shape, 0);
  EXPECT_TRUE(voxels.last_pair(1, 12).are_equal());
  const SampleWeights halves = weights_of(shape, 1);
  EXPECT_EQ(halves.last_pair(0, 6).first, 2);
  EXPECT_EQ(halves.last_pair(0, 6).second, 1);
  EXPECT_TRUE(halves.last_pair(1, 6).are_equal());
  EXPECT_TRUE(halves.last_pair(2, 7).are_equal());  // the last one has no partner
}

}  // namespace
}  // namespace octavo
