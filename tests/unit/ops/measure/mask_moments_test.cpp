// The moments of masks against sums over dense arrays.
#include "octavo/ops/measure/mask_moments.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;

MomentSums dense_moments(const DenseMask& mask) {
  MomentSums sums;
  testing::for_each_voxel(mask.size, [&](const Index3& p) {
    if (mask.at(p) != 0) sums.add_box({p, {p.x + 1, p.y + 1, p.z + 1}});
  });
  return sums;
}

void expect_same(const MomentSums& found, const MomentSums& expected) {
  EXPECT_EQ(found.count, expected.count);
  EXPECT_EQ(found.box, expected.box);
  EXPECT_TRUE(found.first == expected.first);
  EXPECT_TRUE(found.second == expected.second);
}

TEST(MomentSums, OfABoxAreThoseOfItsVoxels) {
  const Box box{{3, 0, 7}, {9, 4, 8}};
  MomentSums whole;
  whole.add_box(box);
  std::int64_t xx = 0;
  std::int64_t yz = 0;
  testing::for_each_voxel(box.size(), [&](const Index3& p) {
    xx += (p.x + 3) * (p.x + 3);
    yz += p.y * (p.z + 7);
  });
  EXPECT_TRUE(whole.second[0] == xx);
  EXPECT_TRUE(whole.second[5] == yz);
  EXPECT_DOUBLE_EQ(whole.centroid()[0], 5.5);
  EXPECT_DOUBLE_EQ(whole.covariance()[1], 1.25);
  EXPECT_DOUBLE_EQ(whole.covariance()[3], 0);
}

TEST(MaskMoments, AreTheSumsOverAllVoxels) {
  std::mt19937 random(5);
  for (const Size3& size : testing::odd_sizes()) {
    for (int round = 0; round < 4; ++round) {
      const DenseMask mask = testing::random_mask(size, random);
      expect_same(mask_moments(testing::tree_of(mask)), dense_moments(mask));
    }
  }
}

TEST(MaskMoments, OfLargeCubesAreThoseOfTheirBox) {
  const Size3 size{270, 1025, 600};
  for (const Box& box : {box_of(size), Box{{3, 1, 255}, {269, 1025, 599}}}) {
    MomentSums expected;
    expected.add_box(box);
    expect_same(mask_moments(box_mask(size, box)), expected);
  }
}

TEST(MaskMoments, OfNothingAreNone) {
  const MomentSums sums = mask_moments(MaskTree({100, 3, 70}));
  EXPECT_EQ(sums.count, 0u);
  EXPECT_TRUE(sums.box.is_empty());
}

TEST(MaskMoments, DoNotDependOnTheThreads) {
  std::mt19937 random(8);
  const MaskTree mask = testing::tree_of(testing::random_mask({200, 150, 170}, random));
  MomentSums one;
  tbb::task_arena(1).execute([&] { one = mask_moments(mask); });
  tbb::task_arena(3).execute([&] { expect_same(mask_moments(mask), one); });
}

}  // namespace
}  // namespace octavo
