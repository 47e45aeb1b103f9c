#include "octavo/ops/morphometry/local_thickness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/dense_mask.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

template <class Inside>
DenseMask solid(const Size3& size, Inside inside) {
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  for_each_voxel(size, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
  return mask;
}

struct Measured {
  std::vector<float> mm;
  ThicknessSummary summary;
};

Measured measured(const DenseMask& mask, const Point3& spacing, bool is_background = false) {
  const MaskTree tree = testing::tree_of(mask);
  const ThicknessClass asked{tree, nullptr, is_background};
  testing::MemoryStorage storage;
  NoProgress progress;
  const auto balls = fitting_balls(asked, spacing, {1 << 30, storage, "."}, progress);
  const LocalThickness thickness(asked, spacing, balls);
  Measured result;
  result.mm.resize(mask.voxels.size());
  const std::int64_t plane = mask.size.x * mask.size.y;
  for (std::int64_t z = 0; z < mask.size.z; z += 7) {
    thickness.read(z, std::min(z + 7, mask.size.z), result.mm.data() + z * plane);
  }
  thickness.add(result.mm.data(), mask.size.voxel_count(), result.summary);
  LocalThickness::finish(result.summary);
  return result;
}

TEST(LocalThickness, OfPlatesIsWhatTheyAreThick) {
  for (const std::int64_t thick : {1, 2, 3, 8, 9}) {
    const DenseMask mask =
        solid({40, 40, 30}, [&](const Index3& p) { return p.z >= 10 && p.z < 10 + thick; });
    const ThicknessSummary summary = measured(mask, {0.5, 0.5, 0.25}).summary;
    EXPECT_EQ(summary.voxels, static_cast<std::uint64_t>(1600 * thick));
    EXPECT_NEAR(summary.mean_mm, 0.25 * static_cast<double>(thick), 1e-6);
    EXPECT_NEAR(summary.deviation_mm, 0, 1e-6);
  }
}

TEST(LocalThickness, OfTheBackgroundIsTheWidthOfGaps) {
  const DenseMask mask = solid({30, 30, 44}, [](const Index3& p) { return p.z % 10 < 4; });
  const ThicknessSummary summary = measured(mask, {1, 1, 1}, true).summary;
  EXPECT_NEAR(summary.mean_mm, 6, 1e-6);
}

TEST(LocalThickness, OfSpheresAndRodsIsTheirDiameter) {
  const auto is_in_sphere = [](const Index3& p) {
    const auto x = static_cast<double>(p.x) - 31.7;
    const auto y = static_cast<double>(p.y) - 32.2;
    const auto z = static_cast<double>(p.z) - 31.4;
    return x * x + y * y + z * z <= 28 * 28;
  };
  const ThicknessSummary sphere = measured(solid({64, 64, 64}, is_in_sphere), {1, 1, 1}).summary;
  EXPECT_NEAR(sphere.mean_mm / 56, 1, 0.02);
  const auto is_in_rod = [](const Index3& p) {
    const auto x = static_cast<double>(p.x) - 31.7;
    const auto y = static_cast<double>(p.y) - 32.2;
    return x * x + y * y <= 28 * 28;
  };
  const ThicknessSummary rod = measured(solid({64, 64, 20}, is_in_rod), {1, 1, 1}).summary;
  EXPECT_NEAR(rod.mean_mm / 56, 1, 0.02);
}

/// The largest of the balls around all centers that covers each voxel, and its thickness where
/// no ball ends half a voxel before the center that it meets.
std::vector<float> searched_thickness(const DenseMask& mask) {
  const Size3 size = mask.size;
  std::vector<float> mm(mask.voxels.size());
  const auto squared_between = [](const Index3& p, const Index3& q) {
    const Index3 step = {p.x - q.x, p.y - q.y, p.z - q.z};
    return step.x * step.x + step.y * step.y + step.z * step.z;
  };
  for_each_voxel(size, [&](const Index3& p) {
    if (mask.at(p) == 0) return;
    std::int64_t nearest = INT64_MAX;
    for_each_voxel(size, [&](const Index3& q) {
      if (mask.at(q) == 0) nearest = std::min(nearest, squared_between(p, q));
    });
    const double reach = std::sqrt(static_cast<double>(nearest));
    for_each_voxel(size, [&](const Index3& q) {
      float& value = mm[static_cast<std::size_t>((q.z * size.y + q.y) * size.x + q.x)];
      if (squared_between(p, q) < nearest) value = std::max(value, static_cast<float>(2 * reach));
    });
  });
  return mm;
}

TEST(LocalThickness, IsNearlyThatOfAllBalls) {
  std::mt19937 random(7);
  const DenseMask mask = solid({17, 16, 15}, [&](const Index3& p) {
    const auto x = static_cast<double>(p.x);
    const auto y = static_cast<double>(p.y);
    const auto z = static_cast<double>(p.z);
    return std::sin(x * 0.6) * std::cos(y * 0.5) + std::sin(y * 0.5) * std::cos(z * 0.6) > 0.1;
  });
  const std::vector<float> expected = searched_thickness(mask);
  const std::vector<float> made = measured(mask, {1, 1, 1}).mm;
  double sum = 0;
  double off = 0;
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_LE(made[i], expected[i] * (1 + 1e-6));
    EXPECT_GE(made[i], expected[i] - 1.2F);
    EXPECT_EQ(made[i] > 0, expected[i] > 0);
    sum += static_cast<double>(expected[i]);
    off += static_cast<double>(expected[i] - made[i]);
  }
  // Half a voxel at each end of balls that meet layers of voxels.
  EXPECT_LT(off / sum, 0.15);
}

}  // namespace
}  // namespace octavo
