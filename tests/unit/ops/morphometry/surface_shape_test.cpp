#include "octavo/ops/morphometry/surface_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

template <class Inside>
SurfaceShape shape_of(const Size3& size, const Point3& spacing, Inside inside) {
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  for_each_voxel(size, [&](const Index3& p) {
    mask.at(p) = inside((static_cast<double>(p.x) + 0.5) * spacing[0],
                        (static_cast<double>(p.y) + 0.5) * spacing[1],
                        (static_cast<double>(p.z) + 0.5) * spacing[2]) ? 1 : 0;
  });
  NoProgress progress;
  return surface_shape(testing::tree_of(mask), nullptr, spacing, progress);
}

TEST(SurfaceShape, OfSpheresIsTheirAreaAndItsGrowth) {
  const auto is_in = [](double x, double y, double z) {
    return (x - 25.1) * (x - 25.1) + (y - 24.8) * (y - 24.8) + (z - 25.4) * (z - 25.4) <= 20 * 20;
  };
  for (const Point3& spacing : {Point3{1, 1, 1}, Point3{0.8, 0.8, 1.2}}) {
    const Size3 size = {static_cast<std::int64_t>(50 / spacing[0]),
                        static_cast<std::int64_t>(50 / spacing[1]),
                        static_cast<std::int64_t>(50 / spacing[2])};
    const SurfaceShape shape = shape_of(size, spacing, is_in);
    EXPECT_NEAR(shape.area_mm2 / (4 * std::numbers::pi * 400), 1, 0.012);
    EXPECT_NEAR(shape.growth_mm / (8 * std::numbers::pi * 20), 1, 0.02);
    EXPECT_EQ(shape.cut_mm2, 0);
  }
}

TEST(SurfaceShape, OfPlatesDoesNotGrowAndEndsAreCut) {
  const SurfaceShape shape =
      shape_of({30, 40, 50}, {0.5, 0.5, 0.5}, [](double, double, double z) {
        return z > 10 && z < 14;
      });
  EXPECT_NEAR(shape.area_mm2, 2 * 15 * 20, 1e-6);
  EXPECT_NEAR(shape.growth_mm, 0, 1e-6);
  EXPECT_NEAR(shape.cut_mm2, 2 * 4 * (15 + 20), 1e-6);
}

TEST(SurfaceShape, OfAGyroidIsThatOfItsUnitCells) {
  constexpr double kWave = 2 * std::numbers::pi / 30;
  const SurfaceShape shape = shape_of({60, 60, 60}, {1, 1, 1}, [](double x, double y, double z) {
    return std::sin(kWave * x) * std::cos(kWave * y) + std::sin(kWave * y) * std::cos(kWave * z) +
               std::sin(kWave * z) * std::cos(kWave * x) > 0;
  });
  // The trigonometric surface has 3.0919 times the square of its cell's side.
  EXPECT_NEAR(shape.area_mm2 / (8 * 3.0919 * 30 * 30), 1, 0.015);
}

}  // namespace
}  // namespace octavo
