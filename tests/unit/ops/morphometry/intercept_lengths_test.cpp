#include "octavo/ops/morphometry/intercept_lengths.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

template <class Inside>
std::optional<Anisotropy> anisotropy_of(const Size3& size, const Point3& spacing, Inside inside) {
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  for_each_voxel(size, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
  NoProgress progress;
  return anisotropy(testing::tree_of(mask), nullptr, spacing, progress);
}

TEST(Anisotropy, OfPlatesIsOneAlongTheirNormal) {
  const auto plates = anisotropy_of({60, 60, 60}, {1, 1, 1},
                                    [](const Index3& p) { return p.z % 10 >= 3 && p.z % 10 < 7; });
  ASSERT_TRUE(plates);
  EXPECT_GT(plates->degree, 0.98);
  EXPECT_GT(std::abs(plates->axes[2][2]), 0.999);
  // Two surfaces every 10 voxels.
  EXPECT_NEAR(plates->lengths_mm[2], 5, 0.3);
}

TEST(Anisotropy, OfAStructureAlikeAlongAllAxesIsNone) {
  constexpr double kWave = 2 * std::numbers::pi / 20;
  const auto gyroid = anisotropy_of({80, 80, 80}, {1, 1, 1}, [](const Index3& p) {
    const double x = kWave * static_cast<double>(p.x);
    const double y = kWave * static_cast<double>(p.y);
    const double z = kWave * static_cast<double>(p.z);
    return std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x) > 0;
  });
  ASSERT_TRUE(gyroid);
  EXPECT_LT(gyroid->degree, 0.05);
}

TEST(Anisotropy, CountsInMm) {
  // The same gyroid in cubes, and in voxels that are half as high.
  constexpr double kWave = 2 * std::numbers::pi / 20;
  const auto degree_of = [&](std::int64_t planes) {
    const double height = 60.0 / static_cast<double>(planes);
    return anisotropy_of({60, 60, planes}, {1, 1, height}, [&](const Index3& p) {
      const double x = kWave * static_cast<double>(p.x);
      const double y = kWave * static_cast<double>(p.y);
      const double z = kWave * height * static_cast<double>(p.z);
      return std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x) > 0;
    })->degree;
  };
  EXPECT_NEAR(degree_of(60), degree_of(120), 0.04);
}

TEST(Anisotropy, OfWhatHasNoSurfaceIsNotKnown) {
  EXPECT_FALSE(anisotropy_of({9, 9, 9}, {1, 1, 1}, [](const Index3&) { return false; }));
}

}  // namespace
}  // namespace octavo
