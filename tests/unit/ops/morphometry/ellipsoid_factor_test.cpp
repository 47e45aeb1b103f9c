#include "octavo/ops/morphometry/ellipsoid_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "octavo/core/vectors.h"
#include "support/dense_mask.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

template <class Inside>
EllipsoidFactors factors_of(const Size3& size, const Point3& spacing, Inside inside) {
  testing::DenseMask mask{size,
                          std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  testing::for_each_voxel(size, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
  const MaskTree tree = testing::tree_of(mask);
  const ThicknessClass asked{tree, nullptr, false};
  testing::MemoryStorage storage;
  NoProgress progress;
  const auto sites = make_site_field(inside_of(tree), spacing, 1 << 30, storage, ".", progress);
  const auto balls = fitting_balls(asked, spacing, *sites, progress);
  const auto factors = ellipsoid_factors(asked, spacing, balls, progress);
  EXPECT_TRUE(factors.has_value());
  const EllipsoidFactors found = factors.value_or(EllipsoidFactors{});
  EXPECT_NEAR(std::accumulate(found.shares.begin(), found.shares.end(), 0.0), 1, 1e-9);
  return found;
}

TEST(EllipsoidFactor, TellsPlatesFromRodsFromBalls) {
  const auto plate = factors_of({120, 120, 16}, {1, 1, 1}, [](const Index3& p) {
    return p.z >= 7 && p.z < 10;
  });
  EXPECT_LT(plate.mean, -0.75);
  const auto rod = factors_of({30, 30, 80}, {1, 1, 1}, [](const Index3& p) {
    const std::int64_t x = p.x - 15;
    const std::int64_t y = p.y - 14;
    return x * x + y * y <= 16;
  });
  EXPECT_GT(rod.mean, 0.6);
  const auto ball = factors_of({50, 50, 50}, {1, 1, 1}, [](const Index3& p) {
    const Index3 d = {p.x - 25, p.y - 25, p.z - 25};
    return d.x * d.x + d.y * d.y + d.z * d.z <= 400;
  });
  EXPECT_NEAR(ball.mean, 0, 0.1);
}

TEST(EllipsoidFactor, OfEllipsoidsIsThatOfTheirAxes) {
  // Turned, so that no axis lies along the grid.
  const std::array<Point3, 3> axes = {{{2.0 / 3, -2.0 / 3, 1.0 / 3},
                                       {1.0 / 3, 2.0 / 3, 2.0 / 3},
                                       {-2.0 / 3, -1.0 / 3, 2.0 / 3}}};
  for (const Point3& lengths : {Point3{8, 12, 24}, Point3{10, 10, 26}, Point3{6, 20, 20}}) {
    const auto found = factors_of({56, 56, 56}, {1, 1, 1}, [&](const Index3& p) {
      const Point3 d = {static_cast<double>(p.x) - 27.8, static_cast<double>(p.y) - 27.6,
                        static_cast<double>(p.z) - 28.1};
      double squares = 0;
      for (std::size_t a = 0; a < 3; ++a) squares += std::pow(dot(d, axes[a]) / lengths[a], 2);
      return squares <= 1;
    });
    EXPECT_NEAR(found.mean, lengths[0] / lengths[1] - lengths[1] / lengths[2], 0.03)
        << lengths[0] << " " << lengths[1] << " " << lengths[2];
  }
}

TEST(EllipsoidFactor, SpacingCounts) {
  // A ball of voxels of 1 x 1 x 4: a rod.
  const auto rod = factors_of({50, 50, 50}, {1, 1, 4}, [](const Index3& p) {
    const Index3 d = {p.x - 25, p.y - 25, p.z - 25};
    return d.x * d.x + d.y * d.y + d.z * d.z <= 400;
  });
  EXPECT_GT(rod.mean, 0.5);
}

TEST(EllipsoidFactor, TheBorderOfTheVolumeHoldsEllipsoids) {
  // A post across thin volumes, whose balls reach far beyond them: a plate.
  const auto post = factors_of({60, 60, 6}, {1, 1, 1}, [](const Index3& p) {
    const std::int64_t x = p.x - 30;
    const std::int64_t y = p.y - 30;
    return x * x + y * y <= 500;
  });
  EXPECT_LT(post.mean, -0.6);
}

TEST(EllipsoidFactor, TheMeanIsThatOfWhatIsHeld) {
  // A ball of three quarters of the volume, and a rod of a quarter, that has far more centers.
  const auto both = factors_of({90, 40, 40}, {1, 1, 1}, [](const Index3& p) {
    const std::int64_t y = p.y - 20;
    const std::int64_t z = p.z - 20;
    const bool is_rod = p.x >= 46 && p.x < 86 && y * y + z * z <= 16;
    const std::int64_t x = p.x - 20;
    return is_rod || x * x + y * y + z * z <= 225;
  });
  EXPECT_GT(both.shares[9] + both.shares[10], 0.7);
  EXPECT_GT(both.mean, 0.02);
  EXPECT_LT(both.mean, 0.25);
}

}  // namespace
}  // namespace octavo
