#include "octavo/ops/morphometry/box_counts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

TEST(BoxCounts, AreThoseOfASearchThroughAllVoxels) {
  std::mt19937 random(4);
  for (const Size3& size : testing::odd_sizes()) {
    const DenseMask mask = testing::random_mask(size, random);
    for (const BoxCount& one : box_counts(testing::tree_of(mask))) {
      std::uint64_t holding = 0;
      std::uint64_t mixed = 0;
      const auto boxes_of = [&](std::int64_t count) { return (count + one.side - 1) / one.side; };
      for_each_voxel({boxes_of(size.x), boxes_of(size.y), boxes_of(size.z)}, [&](const Index3& b) {
        bool is_any = false;
        bool is_all = true;
        for_each_voxel({one.side, one.side, one.side}, [&](const Index3& p) {
          const Index3 q = {b.x * one.side + p.x, b.y * one.side + p.y, b.z * one.side + p.z};
          const bool is_inside = box_of(size).contains(q) && mask.at(q) != 0;
          is_any = is_any || is_inside;
          is_all = is_all && is_inside;
        });
        holding += is_any ? 1 : 0;
        mixed += is_any && !is_all ? 1 : 0;
      });
      EXPECT_EQ(one.holding, holding) << one.side;
      EXPECT_EQ(one.mixed, mixed) << one.side;
      if (one.side > 64) break;
    }
  }
}

TEST(BoxCounts, OfPlatesRodsAndASpongeHaveTheirDimension) {
  const auto fit_of = [](std::int64_t side, const auto& inside) {
    const Size3 size = {side, side, side};
    DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
    for_each_voxel(size, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
    return fractal_dimension(box_counts(testing::tree_of(mask)), size, false).value();
  };
  const FractalFit plate = fit_of(64, [](const Index3& p) { return p.z == 21; });
  EXPECT_NEAR(plate.dimension, 2, 1e-9);
  EXPECT_NEAR(plate.r2, 1, 1e-9);
  EXPECT_EQ(plate.smallest_side, 2);
  EXPECT_EQ(plate.largest_side, 16);
  EXPECT_NEAR(fit_of(64, [](const Index3& p) { return p.z == 2 && p.x == 9; }).dimension, 1, 1e-9);
  // Voxels no two digits of whose coordinates are both 1: a tetrahedron of Sierpinski.
  const FractalFit sponge = fit_of(64, [](const Index3& p) {
    return (p.x & p.y) == 0 && (p.y & p.z) == 0 && (p.x & p.z) == 0;
  });
  EXPECT_NEAR(sponge.dimension, 2, 1e-9);
}

}  // namespace
}  // namespace octavo
