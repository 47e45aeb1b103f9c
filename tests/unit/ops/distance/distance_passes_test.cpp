#include "octavo/ops/distance/distance_passes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

/// The distance of each voxel by looking at every voxel of the other class.
std::vector<double> searched_distances(const DenseMask& mask, const DistanceSettings& settings) {
  std::vector<double> all;
  for_each_voxel(mask.size, [&](const Index3& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for_each_voxel(mask.size, [&](const Index3& q) {
      if (mask.at(p) == mask.at(q)) return;
      double squared = 0;
      for (int axis = 0; axis < 3; ++axis) {
        double steps = std::abs(static_cast<double>(p[axis] - q[axis]));
        if (settings.to == DistanceTo::faces) steps = std::max(0.0, steps - 0.5);
        const double mm = steps * settings.spacing_mm[static_cast<std::size_t>(axis)];
        squared += mm * mm;
      }
      nearest = std::min(nearest, squared);
    });
    all.push_back((mask.at(p) != 0 ? -1 : 1) * std::sqrt(nearest));
  });
  return all;
}

void expect_distances(const DenseMask& mask, const DistanceSettings& settings) {
  NoProgress progress;
  const std::vector<float> made = signed_distances(testing::tree_of(mask), settings, progress);
  const std::vector<double> expected = searched_distances(mask, settings);
  ASSERT_EQ(made.size(), expected.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    if (std::isinf(expected[i])) {
      EXPECT_EQ(made[i], expected[i]);
    } else {
      ASSERT_NEAR(made[i], expected[i], 2e-7 * std::abs(expected[i])) << "voxel " << i;
    }
  }
}

constexpr Point3 kSpacings[] = {{1, 1, 1}, {0.5, 0.5, 2}, {0.3, 0.7, 0.11}};

TEST(DistancePasses, AreThoseOfASearchThroughAllVoxels) {
  std::mt19937 random(25);
  for (const Size3& size : {Size3{9, 7, 6}, {1, 1, 20}, {20, 1, 1}, {1, 13, 5}, {11, 10, 9}}) {
    for (const Point3& spacing : kSpacings) {
      for (const DistanceTo to : {DistanceTo::faces, DistanceTo::centers}) {
        expect_distances(testing::random_mask(size, random), {to, spacing});
      }
    }
  }
}

TEST(DistancePasses, OfOneVoxelReachAllOthers) {
  DenseMask mask{{12, 9, 10}, std::vector<std::uint8_t>(12 * 9 * 10)};
  mask.at({3, 7, 1}) = 1;
  for (const Point3& spacing : kSpacings) {
    expect_distances(mask, {DistanceTo::centers, spacing});
    expect_distances(mask, {DistanceTo::faces, spacing});
  }
}

TEST(DistancePasses, AreInfiniteWhereThereIsButOneClass) {
  expect_distances({{5, 4, 3}, std::vector<std::uint8_t>(60)}, {});
  expect_distances({{5, 4, 3}, std::vector<std::uint8_t>(60, 1)}, {});
}

TEST(DistancePasses, OfCubesAreExactSquaresFarFromTheMask) {
  DenseMask mask{{300, 1, 1}, std::vector<std::uint8_t>(300)};
  mask.at({0, 0, 0}) = 1;
  NoProgress progress;
  const std::vector<float> made =
      signed_distances(testing::tree_of(mask), {DistanceTo::centers, {0.25, 1, 1}}, progress);
  for (std::size_t x = 1; x < 300; ++x) EXPECT_EQ(made[x], 0.25F * static_cast<float>(x));
}

}  // namespace
}  // namespace octavo
