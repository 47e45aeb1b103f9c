#include "octavo/ops/morphometry/diffusion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "octavo/core/error.h"
#include "support/dense_mask.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::for_each_voxel;

template <class Pore>
std::optional<PoreDiffusion> diffusion_of(const Size3& size, const Point3& spacing, int axis,
                                          Pore pore) {
  std::vector<std::uint8_t> pores;
  for_each_voxel(size, [&](const Index3& p) { pores.push_back(pore(p) ? 1 : 0); });
  NoProgress progress;
  return pore_diffusion(pores, size, spacing, axis, static_cast<double>(size.voxel_count()),
                        progress);
}

TEST(Diffusion, StraightPoresHaveNoTortuosity) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto found = diffusion_of({9, 8, 7}, {0.5, 1, 2}, axis, [&](const Index3& p) {
      return p[(axis + 1) % 3] % 3 == 0 && p[(axis + 2) % 3] % 2 == 0;
    });
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->tortuosity, 1, 1e-6);
    EXPECT_LT(found->imbalance, 1e-6);
  }
}

TEST(Diffusion, LayersInSeriesAddTheirResistance) {
  // Free space, then a pore of a quarter of the area, so wide that the bend around its mouth counts
  // little: resistance between that of straight columns and that of layers in series.
  const auto found = diffusion_of({40, 40, 40}, {1, 1, 1}, 2, [](const Index3& p) {
    return p.z < 20 || (p.x < 20 && p.y < 20);
  });
  ASSERT_TRUE(found);
  const double series = 1 / (0.5 + 0.5 * 4);
  EXPECT_LT(found->effective, series);
  EXPECT_GT(found->effective, 0.25);
}

TEST(Diffusion, IsThatOfAShortSystemSolvedByHand) {
  // Two voxels side by side, two planes; the second plane has one pore. The conductance is 1
  // between voxels and 2 to the ends; the concentration is 1 before the first plane, 0 behind all.
  //     a b    4 a - b - c = 2
  //     c      3 b - a     = 2
  //            3 c - a     = 0
  const auto found = diffusion_of({2, 1, 2}, {1, 1, 1}, 2, [](const Index3& p) {
    return p.z == 0 || p.x == 0;
  });
  ASSERT_TRUE(found);
  const double a = (2 + 2.0 / 3) / (4 - 2.0 / 3);
  const double c = a / 3;
  // Flux 2 c; length 2, area 2.
  EXPECT_NEAR(found->effective, 2 * c * 2 / 2, 1e-6);
  EXPECT_NEAR(found->tortuosity, 0.75 / found->effective, 1e-9);
}

TEST(Diffusion, SpheresSlowItAsMaxwellSays) {
  // One ball in a cube of 40, porosity 1 - f: D_eff = D * (1 - f) / (1 + f / 2).
  const double radius = 12;
  double solid = 0;
  const auto found = diffusion_of({40, 40, 40}, {1, 1, 1}, 0, [&](const Index3& p) {
    const double x = static_cast<double>(p.x) - 19.5;
    const double y = static_cast<double>(p.y) - 19.5;
    const double z = static_cast<double>(p.z) - 19.5;
    const bool is_solid = x * x + y * y + z * z <= radius * radius;
    solid += is_solid ? 1 : 0;
    return !is_solid;
  });
  ASSERT_TRUE(found);
  const double f = solid / 64000;
  EXPECT_NEAR(found->effective, (1 - f) / (1 + f / 2), 0.01);
}

TEST(Diffusion, DeadEndsHoldStill) {
  const auto open = diffusion_of({5, 5, 9}, {1, 1, 1}, 2,
                                 [](const Index3& p) { return p.x == 2 && p.y == 2; });
  const auto with_ends = diffusion_of({5, 5, 9}, {1, 1, 1}, 2, [](const Index3& p) {
    return (p.y == 2 && (p.x == 2 || p.z == 4)) || (p.y == 0 && p.x == 0 && p.z < 5);
  });
  ASSERT_TRUE(open && with_ends);
  EXPECT_NEAR(with_ends->effective, open->effective, 1e-6);
  EXPECT_GT(with_ends->tortuosity, open->tortuosity);
  EXPECT_FALSE(diffusion_of({5, 5, 9}, {1, 1, 1}, 2, [](const Index3& p) { return p.z != 4; }));
}

TEST(Diffusion, SaysHowFarItIsAndStopsWhenAsked) {
  const Size3 size = {24, 24, 24};
  std::vector<std::uint8_t> pores;
  for_each_voxel(size, [&](const Index3& p) { pores.push_back(p.x % 5 < 3 || p.z % 7 == 0); });
  testing::StoppingProgress watching(1 << 30);
  const auto found = pore_diffusion(pores, size, {1, 1, 1}, 2, 24 * 24 * 24, watching);
  ASSERT_TRUE(found);
  EXPECT_EQ(watching.done_, kDiffusionParts);
  // Before the first step of the solution, and at one in its middle.
  for (const int answered : {0, watching.questions_ / 2}) {
    testing::StoppingProgress stopping(answered);
    EXPECT_THROW(pore_diffusion(pores, size, {1, 1, 1}, 2, 24 * 24 * 24, stopping), Error);
    EXPECT_LT(stopping.done_, kDiffusionParts);
    if (answered > 0) {
      EXPECT_GT(stopping.done_, kDiffusionParts / 10);
    }
  }
  testing::StoppingProgress closed(1 << 30);
  EXPECT_FALSE(pore_diffusion(std::vector<std::uint8_t>(pores.size()), size, {1, 1, 1}, 2,
                              24 * 24 * 24, closed));
  EXPECT_EQ(closed.done_, kDiffusionParts);
}

}  // namespace
}  // namespace octavo
