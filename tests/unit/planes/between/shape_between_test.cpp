// Label planes between label planes, and the distances they are decided by.
#include "octavo/planes/between/shape_between.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/planes/between/site_distance.h"

namespace octavo {
namespace {

TEST(SiteDistance, IsThatOfASearchOverAllSites) {
  std::mt19937 numbers(5);
  for (int round = 0; round < 60; ++round) {
    const auto columns = static_cast<std::int64_t>(1 + numbers() % 17);
    const auto rows = static_cast<std::int64_t>(1 + numbers() % 17);
    std::vector<std::uint8_t> mask(static_cast<std::size_t>(columns * rows));
    const auto rarity = 1 + numbers() % 40;
    for (auto& mark : mask) mark = numbers() % rarity == 0 ? 1 : 0;
    mask[numbers() % mask.size()] = 1;
    SiteDistance distance(columns, rows);
    ASSERT_TRUE(distance.mark(mask));
    std::vector<SiteDistance::Nearest> row(static_cast<std::size_t>(columns));
    for (std::int64_t y = 0; y < rows; ++y) {
      distance.measure_row(y, row);
      for (std::int64_t x = 0; x < columns; ++x) {
        std::int64_t minimum = std::numeric_limits<std::int64_t>::max();
        for (std::int64_t i = 0; i < columns * rows; ++i) {
          if (mask[static_cast<std::size_t>(i)] == 0) continue;
          const std::int64_t dx = i % columns - x;
          const std::int64_t dy = i / columns - y;
          minimum = std::min(minimum, dx * dx + dy * dy);
        }
        const SiteDistance::Nearest& found = row[static_cast<std::size_t>(x)];
        const std::int64_t dx = found.index % columns - x;
        const std::int64_t dy = found.index / columns - y;
        ASSERT_EQ(found.squared, minimum);
        ASSERT_EQ(dx * dx + dy * dy, minimum);
        ASSERT_EQ(mask[static_cast<std::size_t>(found.index)], 1);
      }
    }
  }
}

TEST(SiteDistance, TellsWhenThereIsNoSite) {
  SiteDistance distance(3, 2);
  EXPECT_FALSE(distance.mark(std::vector<std::uint8_t>(6, 0)));
}

constexpr std::int64_t kSide = 48;
using Plane = std::vector<std::uint16_t>;

/// A plane with discs in it, later ones over earlier ones.
struct Disc {
  double x = 0;
  double y = 0;
  double radius = 0;
  std::uint16_t label = 1;
};

Plane plane_of(const std::vector<Disc>& discs, std::uint16_t background = 0) {
  Plane plane(kSide * kSide, background);
  for (const Disc& disc : discs)
    for (std::int64_t y = 0; y < kSide; ++y)
      for (std::int64_t x = 0; x < kSide; ++x) {
        const double away = std::hypot(static_cast<double>(x) - disc.x,
                                       static_cast<double>(y) - disc.y);
        if (away <= disc.radius) plane[static_cast<std::size_t>(y * kSide + x)] = disc.label;
      }
  return plane;
}

std::vector<Plane> planes_between(const Plane& below, const Plane& above, int steps) {
  const auto shapes = make_shape_between(kSide, kSide, VoxelType::uint16);
  shapes->set_pair(std::as_bytes(std::span(below)), std::as_bytes(std::span(above)));
  std::vector<WayUp> ways;
  for (int k = 1; k < steps; ++k) ways.push_back({static_cast<double>(k), double(steps)});
  EXPECT_LE(ways.size(), shapes->max_ways());
  shapes->decide(ways);
  std::vector<Plane> planes(ways.size(), Plane(below.size()));
  for (std::size_t k = 0; k < planes.size(); ++k) {
    shapes->fill(k, std::as_writable_bytes(std::span(planes[k])));
  }
  return planes;
}

Plane half_way(const Plane& below, const Plane& above) {
  return planes_between(below, above, 2).front();
}

std::int64_t count_of(const Plane& plane, std::uint16_t label) {
  return std::count(plane.begin(), plane.end(), label);
}

std::int64_t differences(const Plane& a, const Plane& b) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i] ? 1 : 0;
  return count;
}

TEST(ShapeBetween, ADiscThatGrowsHasItsMiddleRadiusHalfWay) {
  const Plane middle = half_way(plane_of({{24, 24, 6}}), plane_of({{24, 24, 16}}));
  EXPECT_LE(differences(middle, plane_of({{24, 24, 11}})), 12);
}

TEST(ShapeBetween, ADiscThatMovesABitStaysADiscInBetween) {
  const Plane middle = half_way(plane_of({{20, 24, 10}}), plane_of({{26, 24, 10}}));
  // The distances of two discs mix to a shape a little flatter than the disc between them.
  EXPECT_LE(differences(middle, plane_of({{23, 24, 10}})), 60);
  EXPECT_EQ(middle[24 * kSide + 23], 1);
}

TEST(ShapeBetween, PixelsWithOneLabelInBothPlanesKeepIt) {
  std::mt19937 numbers(9);
  Plane below(kSide * kSide);
  Plane above(kSide * kSide);
  for (auto& label : below) label = static_cast<std::uint16_t>(numbers() % 4);
  for (auto& label : above) label = static_cast<std::uint16_t>(numbers() % 4);
  for (const Plane& plane : planes_between(below, above, 5)) {
    for (std::size_t i = 0; i < plane.size(); ++i) {
      if (below[i] == above[i]) {
        ASSERT_EQ(plane[i], below[i]);
      }
    }
  }
}

TEST(ShapeBetween, NoLabelIsMadeUp) {
  const Plane below = plane_of({{20, 20, 12, 3}, {30, 30, 8, 700}, {25, 10, 5, 9}}, 2);
  const Plane above = plane_of({{24, 22, 9, 3}, {26, 34, 10, 65535}, {40, 40, 4, 11}}, 2);
  std::set<std::uint16_t> known(below.begin(), below.end());
  known.insert(above.begin(), above.end());
  for (const Plane& plane : planes_between(below, above, 7)) {
    for (const std::uint16_t label : plane) ASSERT_TRUE(known.contains(label)) << label;
  }
}

TEST(ShapeBetween, TheWayDownIsTheWayUpReversed) {
  const Plane below = plane_of({{20, 20, 12, 3}, {30, 30, 8, 7}, {25, 10, 5, 9}}, 2);
  const Plane above = plane_of({{24, 22, 9, 3}, {26, 34, 10, 5}, {40, 40, 4, 11}}, 2);
  const std::vector<Plane> up = planes_between(below, above, 3);
  const std::vector<Plane> down = planes_between(above, below, 3);
  EXPECT_EQ(up[0], down[1]);
  EXPECT_EQ(up[1], down[0]);
}

TEST(ShapeBetween, ALabelThatEndsShrinksToNothingHalfWay) {
  const Plane disc = plane_of({{24, 24, 10}});
  const Plane nothing(disc.size(), 0);
  const std::vector<Plane> planes = planes_between(disc, nothing, 8);
  std::int64_t last = count_of(disc, 1);
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const std::int64_t count = count_of(planes[k], 1);
    EXPECT_TRUE(k >= 3 || (count > 0 && count < last)) << k;
    EXPECT_TRUE(k <= 3 || count == 0) << k;
    last = count;
  }
}

TEST(ShapeBetween, WhereThinLabelsTakeTurnsTheSurroundingsComeBetween) {
  // Label 5 stays as it is and is all around; 1 ends where 2 begins.
  Plane below = plane_of({}, 5);
  Plane above = below;
  for (std::size_t x = 4; x < 44; ++x) {
    below[20 * kSide + x] = 1;
    above[20 * kSide + x] = 2;
    below[30 * kSide + x] = 2;
    above[30 * kSide + x] = 1;
  }
  for (const Plane& plane : planes_between(below, above, 3)) {
    for (std::size_t i = 0; i < plane.size(); ++i) {
      if (below[i] == above[i]) {
        EXPECT_EQ(plane[i], 5);
      }
    }
  }
  const Plane middle = half_way(below, above);
  EXPECT_EQ(count_of(middle, 1) + count_of(middle, 2), 0);
}

/// A ball of `radius` at height `z`, all in pixels.
Plane ball_plane(double radius, double z) {
  const double rest = radius * radius - z * z;
  return rest < 0 ? plane_of({}) : plane_of({{23.3, 23.8, std::sqrt(rest)}});
}

TEST(ShapeBetween, ABallHasItsVolumeAndIsNearerToItThanNearestSlices) {
  // Between slices the radius runs along a chord of the ball: slices far apart make it smaller.
  const struct {
    int steps;
    double volume_tolerance;
  } table[] = {{2, 0.01}, {3, 0.02}, {5, 0.06}};
  const double radius = 19.4;
  for (const auto& [steps, volume_tolerance] : table) {
    std::int64_t volume = 0;
    std::int64_t true_volume = 0;
    std::int64_t wrong = 0;
    std::int64_t wrong_nearest = 0;
    for (int z = -30; z < 30; z += steps) {
      const Plane below = ball_plane(radius, z + 0.4);
      const Plane above = ball_plane(radius, z + steps + 0.4);
      std::vector<Plane> planes = planes_between(below, above, steps);
      planes.insert(planes.begin(), below);
      for (int k = 0; k < steps; ++k) {
        const Plane& plane = planes[static_cast<std::size_t>(k)];
        const Plane exact = ball_plane(radius, z + k + 0.4);
        volume += count_of(plane, 1);
        true_volume += count_of(exact, 1);
        wrong += differences(plane, exact);
        wrong_nearest += differences(2 * k < steps ? below : above, exact);
      }
    }
    EXPECT_NEAR(static_cast<double>(volume) / static_cast<double>(true_volume), 1,
                volume_tolerance)
        << steps;
    EXPECT_LT(wrong, 2 * wrong_nearest / 3) << steps;
  }
}

TEST(ShapeBetween, FloatsAreRejected) {
  EXPECT_THROW(make_shape_between(4, 4, VoxelType::float32), Error);
}

}  // namespace
}  // namespace octavo
