#include "octavo/ops/morphometry/local_thickness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>

#include "octavo/core/vectors.h"
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

Measured measured(const DenseMask& mask, const Point3& spacing, bool is_background = false,
                  const MaskTree* region = nullptr) {
  const MaskTree tree = testing::tree_of(mask);
  const ThicknessClass asked{tree, region, is_background};
  testing::MemoryStorage storage;
  NoProgress progress;
  const auto sites = make_site_field(inside_of(tree), spacing, 1 << 30, storage, ".", progress);
  const auto balls = fitting_balls(asked, spacing, *sites, progress);
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

const std::vector<Point3> kSpacings = {{1, 1, 1}, {1, 1, 2},  {1, 1, 3.5},  {5, 1, 1},
                                       {1, 7, 1}, {1, 1, 10}, {0.1, 1, 7}};

std::string said(const Point3& spacing, int axis, std::int64_t thick) {
  return std::to_string(thick) + " voxels along axis " + std::to_string(axis) + " at " +
         std::to_string(spacing[0]) + ", " + std::to_string(spacing[1]) + ", " +
         std::to_string(spacing[2]);
}

TEST(LocalThickness, OfFlatPlatesAndGapsIsTheirVoxelsAtAnySpacing) {
  for (const Point3& spacing : kSpacings) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int64_t thick : {1, 2, 3, 4, 7}) {
        const DenseMask mask = solid({15, 15, 15}, [&](const Index3& p) {
          return p[axis] < 4 || p[axis] >= 4 + thick;
        });
        const double answer =
            spacing[static_cast<std::size_t>(axis)] * static_cast<double>(thick);
        const ThicknessSummary gap = measured(mask, spacing, true).summary;
        EXPECT_NEAR(gap.mean_mm / answer, 1, 0.003) << said(spacing, axis, thick);
        const DenseMask plate = solid({15, 15, 15}, [&](const Index3& p) {
          return p[axis] >= 4 && p[axis] < 4 + thick;
        });
        const ThicknessSummary summary = measured(plate, spacing).summary;
        EXPECT_NEAR(summary.mean_mm / answer, 1, 0.003) << said(spacing, axis, thick);
      }
    }
  }
}

TEST(LocalThickness, OfSquareRodsIsTheirShorterSideAtAnySpacing) {
  for (const Point3& spacing : kSpacings) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int64_t thick : {1, 2, 3, 4}) {
        const int first = (axis + 1) % 3;
        const int second = (axis + 2) % 3;
        const DenseMask mask = solid({13, 13, 13}, [&](const Index3& p) {
          return p[first] >= 4 && p[first] < 4 + thick && p[second] >= 4 && p[second] < 4 + thick;
        });
        const double answer = std::min(spacing[static_cast<std::size_t>(first)],
                                       spacing[static_cast<std::size_t>(second)]) *
                              static_cast<double>(thick);
        const ThicknessSummary summary = measured(mask, spacing).summary;
        EXPECT_NEAR(summary.mean_mm / answer, 1, 0.003) << said(spacing, axis, thick);
      }
    }
  }
}

TEST(LocalThickness, OfVoxelsAloneIsTheirShortestEdge) {
  for (const Point3& spacing : kSpacings) {
    const DenseMask mask = solid({12, 12, 12}, [&](const Index3& p) {
      return p.x % 5 == 2 && p.y % 5 == 2 && p.z % 5 == 2;
    });
    const ThicknessSummary summary = measured(mask, spacing).summary;
    const double edge = std::min({spacing[0], spacing[1], spacing[2]});
    EXPECT_NEAR(summary.maximum_mm, edge, 1e-6 * edge);
    EXPECT_NEAR(summary.minimum_mm, edge, 1e-6 * edge);
  }
}

TEST(LocalThickness, OfBallsAndRodsOfEightLongVoxelsIsWithinTwoPercent) {
  for (const double slice : {3.0, 5.0}) {
    const double radius = 4 * slice;
    const auto side = static_cast<std::int64_t>(2 * radius) + 8;
    for (const bool is_rod : {false, true}) {
      const DenseMask mask = solid({is_rod ? 12 : side, side, 14}, [&](const Index3& p) {
        const double x = is_rod ? 0 : static_cast<double>(p.x) - 0.5 * static_cast<double>(side);
        const double y = static_cast<double>(p.y) - 0.5 * static_cast<double>(side) + 0.3;
        const double z = (static_cast<double>(p.z) - 6.7) * slice;
        return x * x + y * y + z * z <= radius * radius;
      });
      const ThicknessSummary summary = measured(mask, {1, 1, slice}).summary;
      EXPECT_NEAR(summary.mean_mm / (2 * radius), 1, 0.02) << slice << (is_rod ? " rod" : " ball");
    }
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

/// Twice the reach of the largest of the balls around all places of a grid of half voxels that
/// covers each voxel, searched one by one.
std::vector<double> searched_reach(const DenseMask& mask) {
  const Size3 size = mask.size;
  std::vector<Index3> others;
  for_each_voxel(size, [&](const Index3& q) {
    if (mask.at(q) == 0) others.push_back({2 * q.x, 2 * q.y, 2 * q.z});
  });
  const auto squared_between = [](const Index3& p, const Index3& q) {
    const Index3 step = {p.x - q.x, p.y - q.y, p.z - q.z};
    return step.x * step.x + step.y * step.y + step.z * step.z;
  };
  std::vector<double> found(mask.voxels.size());
  for_each_voxel({2 * size.x + 1, 2 * size.y + 1, 2 * size.z + 1}, [&](const Index3& corner) {
    const Index3 center = {corner.x - 1, corner.y - 1, corner.z - 1};
    std::int64_t nearest = INT64_MAX;
    for (const Index3& q : others) nearest = std::min(nearest, squared_between(center, q));
    const double reach = std::sqrt(static_cast<double>(nearest));
    for_each_voxel(size, [&](const Index3& q) {
      if (squared_between(center, {2 * q.x, 2 * q.y, 2 * q.z}) >= nearest) return;
      double& value = found[static_cast<std::size_t>((q.z * size.y + q.y) * size.x + q.x)];
      value = std::max(value, reach);
    });
  });
  return found;
}

TEST(LocalThickness, IsThatOfTheLargestBallsLessWhatLiesBehindTheSurface) {
  const DenseMask mask = solid({17, 16, 15}, [&](const Index3& p) {
    const auto x = static_cast<double>(p.x);
    const auto y = static_cast<double>(p.y);
    const auto z = static_cast<double>(p.z);
    return std::sin(x * 0.6) * std::cos(y * 0.5) + std::sin(y * 0.5) * std::cos(z * 0.6) > 0.1;
  });
  const std::vector<double> expected = searched_reach(mask);
  const std::vector<float> made = measured(mask, {1, 1, 1}).mm;
  double sum = 0;
  std::vector<double> more;
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(made[i] > 0, mask.voxels[i] != 0);
    if (mask.voxels[i] == 0) continue;
    sum += expected[i];
    more.push_back(static_cast<double>(made[i]) - expected[i]);
  }
  std::sort(more.begin(), more.end());
  const double off = std::accumulate(more.begin(), more.end(), 0.0);
  EXPECT_NEAR(off / sum, 0, 0.05);
  EXPECT_GT(more[more.size() / 20], -1.2);
  EXPECT_LT(more[more.size() * 19 / 20], 0.5);
}

TEST(LocalThickness, OfSpacingsRoundedElsewhereIsTheSame) {
  const DenseMask mask = solid({48, 48, 48}, [](const Index3& p) {
    const double x = 0.31 * static_cast<double>(p.x);
    const double y = 0.29 * static_cast<double>(p.y);
    const double z = 0.33 * static_cast<double>(p.z);
    return std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x) > 0;
  });
  for (const bool is_background : {false, true}) {
    const std::vector<float> cubes = measured(mask, {0.3, 0.3, 0.3}, is_background).mm;
    for (const Point3& rounded :
         {Point3{0.3, 0.3, 0.3 * (1 + 1e-7)}, Point3{0.3, 0.3 * (1 - 1e-6), 0.3}}) {
      const auto mm = measured(mask, thickness_spacing(rounded), is_background).mm;
      for (std::size_t i = 0; i < cubes.size(); ++i) ASSERT_NEAR(mm[i], cubes[i], 1e-5) << i;
    }
  }
  EXPECT_EQ(thickness_spacing({0.3, 0.3, 0.301}), (Point3{0.3, 0.3, 0.301}));
  const Point3 cube = thickness_spacing({2, 2.001, 2});
  EXPECT_EQ(cube, (Point3{cube[0], cube[0], cube[0]}));
  EXPECT_NEAR(cube[0] * cube[0] * cube[0], 2 * 2.001 * 2, 1e-12);
}

TEST(LocalThickness, BallsHoldNoCenterOfTheOtherClass) {
  const DenseMask mask = solid({24, 20, 18}, [](const Index3& p) {
    return (p.x * 7 + p.y * 3 + p.z * 5) % 61 != 0;
  });
  const Point3 spacing = {1, 1.5, 0.7};
  const MaskTree tree = testing::tree_of(mask);
  testing::MemoryStorage storage;
  NoProgress progress;
  const auto sites = make_site_field(inside_of(tree), spacing, 1 << 30, storage, ".", progress);
  const auto balls = fitting_balls({tree, nullptr, false}, spacing, *sites, progress);
  ASSERT_GT(balls.size(), 100u);
  for (const FittingBall& ball : balls) {
    EXPECT_LE(ball.radius_mm, ball.reach_mm);
    double nearest = HUGE_VAL;
    for_each_voxel(mask.size, [&](const Index3& q) {
      if (mask.at(q) != 0) return;
      Point3 way{};
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        way[a] = spacing[a] * (static_cast<double>(q[axis]) + 0.5 -
                               static_cast<double>(ball.center[a]));
      }
      nearest = std::min(nearest, std::sqrt(dot(way, way)));
    });
    EXPECT_GE(nearest, static_cast<double>(ball.reach_mm) - 0.1);
  }
}

/// Forms by the distance from their middle.
struct KnownThickness {
  const char* name;
  double (*distance)(const Point3& p);
};

TEST(LocalThickness, QuantilesLieBetweenTheSmallestAndTheLargest) {
  ThicknessSummary summary;
  summary.voxels = 100;
  summary.bin_mm = 1;
  summary.minimum_mm = 2.3;
  summary.maximum_mm = 4.2;
  summary.bins = {0, 0, 20, 0, 80};
  EXPECT_DOUBLE_EQ(summary.quantile_mm(0.01), 2.3);
  EXPECT_DOUBLE_EQ(summary.quantile_mm(0.15), 2.75);
  EXPECT_DOUBLE_EQ(summary.quantile_mm(0.9), 4.2);
}

TEST(LocalThickness, OfRandomlyTurnedFormsIsWithinTwoPercent) {
  const KnownThickness forms[] = {
      {"ball", [](const Point3& p) { return std::sqrt(dot(p, p)); }},
      {"rod", [](const Point3& p) { return std::hypot(p[0], p[1]); }},
      {"plate", [](const Point3& p) { return std::abs(p[0]); }}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-0.5, 0.5);
  for (const KnownThickness& form : forms) {
    for (const double radius : {5.0, 8.0, 12.0}) {
      const auto side = static_cast<std::int64_t>(2 * (1.75 * radius + 10));
      const Point3 first = unit({anywhere(random), anywhere(random), anywhere(random)});
      const Point3 second = unit(cross(first, {0.2, 0.5, -0.7}));
      const Point3 third = cross(first, second);
      const Point3 middle = {0.5 * static_cast<double>(side) + anywhere(random),
                             0.5 * static_cast<double>(side) + anywhere(random),
                             0.5 * static_cast<double>(side) + anywhere(random)};
      const DenseMask mask = solid({side, side, side}, [&](const Index3& p) {
        const Point3 at = difference({static_cast<double>(p.x), static_cast<double>(p.y),
                                      static_cast<double>(p.z)}, middle);
        return form.distance({dot(at, first), dot(at, second), dot(at, third)}) <= radius;
      });
      // Balls that begin farther from the border than they reach.
      const auto inset = static_cast<std::int64_t>(1.5 * radius + 4);
      const DenseMask region = solid({side, side, side}, [&](const Index3& p) {
        return std::min({p.x, p.y, p.z}) >= inset && std::max({p.x, p.y, p.z}) < side - inset;
      });
      const MaskTree tree = testing::tree_of(region);
      const double mean = measured(mask, {1, 1, 1}, false, &tree).summary.mean_mm;
      EXPECT_NEAR(mean / (2 * radius), 1, 0.02) << form.name << " of radius " << radius;
    }
  }
}

}  // namespace
}  // namespace octavo
