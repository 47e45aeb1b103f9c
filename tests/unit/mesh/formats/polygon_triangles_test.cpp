#include "octavo/mesh/formats/polygon_triangles.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "support/counted_memory.h"

namespace octavo {
namespace {

std::vector<MeshTriangle> polygon_triangles(const std::vector<MeshPoint>& points,
                                            const std::vector<std::uint32_t>& corners) {
  // One for all: what it keeps of the last polygon changes nothing.
  static PolygonCutter cutter;
  const auto triangles = cutter.cut(points, corners);
  return {triangles.begin(), triangles.end()};
}

using Outline = std::vector<std::array<double, 2>>;

/// An outline in a plane through space, and where it is seen from.
struct PolygonInSpace {
  std::vector<MeshPoint> points;
  std::vector<std::uint32_t> corners;
  Point3 normal{};
};

PolygonInSpace in_space(const Outline& outline, std::mt19937& random) {
  std::normal_distribution<double> any;
  const Point3 across = unit({any(random), any(random), any(random)});
  const Point3 normal = unit(cross(across, {any(random), any(random), any(random)}));
  const Point3 up = cross(normal, across);
  PolygonInSpace polygon{{}, {}, normal};
  for (const auto& [x, y] : outline) {
    MeshPoint& point = polygon.points.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      point[i] = static_cast<float>(30 + x * across[i] + y * up[i]);
    }
    polygon.corners.push_back(static_cast<std::uint32_t>(polygon.corners.size()));
  }
  return polygon;
}

double area_of(const Outline& outline) {
  double twice = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const auto& a = outline[i];
    const auto& b = outline[(i + 1) % outline.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return twice / 2;
}

/// The triangles fill an outline that turns left, each place once, and have its sides.
void expect_filled(const Outline& outline, std::mt19937& random) {
  const PolygonInSpace polygon = in_space(outline, random);
  const auto triangles = polygon_triangles(polygon.points, polygon.corners);
  ASSERT_EQ(triangles.size(), outline.size() - 2);
  const double area = area_of(outline);
  double filled = 0;
  std::set<std::pair<std::uint32_t, std::uint32_t>> sides;
  for (const MeshTriangle& triangle : triangles) {
    std::array<Point3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
      const MeshPoint& p = polygon.points[triangle[i]];
      at[i] = {p[0], p[1], p[2]};
      EXPECT_TRUE(sides.insert({triangle[i], triangle[(i + 1) % 3]}).second);
    }
    const Point3 twice = cross(difference(at[1], at[0]), difference(at[2], at[0]));
    EXPECT_GT(dot(twice, polygon.normal), -1e-4 * area);
    filled += std::sqrt(dot(twice, twice)) / 2;
  }
  EXPECT_NEAR(filled, area, 1e-4 * area);
  for (std::uint32_t i = 0; i < outline.size(); ++i) {
    const auto next = static_cast<std::uint32_t>((i + 1) % outline.size());
    EXPECT_TRUE(sides.contains({i, next})) << i;
  }
}

TEST(PolygonTriangles, ConvexPolygonsAreFansAroundTheirFirstCorner) {
  const std::vector<MeshPoint> points = {{0, 0, 0}, {4, 0, 0}, {6, 3, 0}, {3, 6, 0}, {0, 4, 0}};
  EXPECT_EQ(polygon_triangles(points, std::vector<std::uint32_t>{0, 1, 2, 3, 4}),
            (std::vector<MeshTriangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  EXPECT_TRUE(polygon_triangles(points, std::vector<std::uint32_t>{0, 1}).empty());
}

TEST(PolygonTriangles, OutlinesOfManyDentsAreFilledOnce) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> radius(1, 20);
  for (int round = 0; round < 60; ++round) {
    const int count = 4 + round;
    Outline star;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      const double r = radius(random);
      star.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    expect_filled(star, random);
  }
  // A comb, whose teeth are deep, and a spiral.
  Outline comb = {{0, 10}, {0, 0}, {80, 0}, {80, 10}};
  for (int tooth = 39; tooth > 0; --tooth) {
    comb.push_back({2.0 * tooth, 1});
    comb.push_back({2.0 * tooth - 1, 10});
  }
  expect_filled(comb, random);
  Outline spiral;
  for (int i = 0; i <= 60; ++i) {
    spiral.push_back({(2 + 0.3 * i) * std::cos(0.3 * i), (2 + 0.3 * i) * std::sin(0.3 * i)});
  }
  for (int i = 60; i >= 0; --i) {
    spiral.push_back({(1 + 0.3 * i) * std::cos(0.3 * i), (1 + 0.3 * i) * std::sin(0.3 * i)});
  }
  expect_filled(spiral, random);
}

TEST(PolygonTriangles, CornersOnSidesAndHolesBehindASlitAreFilled) {
  std::mt19937 random(3);
  expect_filled({{0, 0}, {2, 0}, {4, 0}, {4, 4}, {2, 4}, {0, 4}}, random);
  expect_filled({{4, 4}, {2, 4}, {0, 4}, {0, 0}, {2, 0}, {4, 0}}, random);
  // A square with a square hole: the outline goes in and out over one slit.
  expect_filled({{0, 0}, {9, 0}, {9, 9}, {0, 9}, {0, 0}, {3, 3}, {3, 6}, {6, 6}, {6, 3}, {3, 3}},
                random);
}

TEST(PolygonTriangles, PolygonsThatAreNotFlatAreSeenAlongTheirNormal) {
  // A chevron whose corners lie up to 1 off its plane.
  const std::vector<MeshPoint> points = {{-20, 1, -20}, {20, -1, 0}, {-20, 1, 20}, {0, -1, 0}};
  const auto triangles = polygon_triangles(points, std::vector<std::uint32_t>{0, 1, 2, 3});
  double filled = 0;
  for (const MeshTriangle& triangle : triangles) {
    std::array<Point3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) {
      at[i] = {points[triangle[i]][0], 0, points[triangle[i]][2]};
    }
    const Point3 twice = cross(difference(at[1], at[0]), difference(at[2], at[0]));
    filled += std::abs(twice[1]);
  }
  EXPECT_EQ(filled / 2, 400);
}

TEST(PolygonTriangles, WhatHasNoInsideStillGivesItsTriangles) {
  const std::vector<MeshPoint> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_EQ(polygon_triangles(line, std::vector<std::uint32_t>{0, 1, 2, 3}).size(), 2u);
  const std::vector<MeshPoint> crossed = {{0, 0, 0}, {3, 2, 0}, {3, 0, 0}, {0, 1, 0}, {1, 5, 0}};
  EXPECT_EQ(polygon_triangles(crossed, std::vector<std::uint32_t>{0, 1, 2, 3, 4}).size(), 3u);
  std::vector<MeshPoint> dented((std::size_t{1} << 16) + 1);
  for (std::size_t i = 0; i < dented.size(); ++i) {
    dented[i] = {static_cast<float>(i), static_cast<float>(i % 2), 0};
  }
  dented.back() = {0, 9, 0};
  std::vector<std::uint32_t> corners(dented.size());
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
  EXPECT_THROW(polygon_triangles(dented, corners), Error);
}

TEST(PolygonTriangles, RoundPolygonsOfAnyNumberOfCornersAreFans) {
  std::vector<MeshPoint> circle(70000);
  std::vector<std::uint32_t> corners(circle.size());
  for (std::size_t i = 0; i < circle.size(); ++i) {
    const double angle =
        2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(circle.size());
    circle[i] = {static_cast<float>(50 * std::cos(angle)), static_cast<float>(50 * std::sin(angle)),
                 7};
    corners[i] = static_cast<std::uint32_t>(i);
  }
  EXPECT_EQ(polygon_triangles(circle, corners).size(), circle.size() - 2);
}

TEST(PolygonTriangles, QuadsTakeNoMemoryOfTheirOwn) {
  const std::vector<MeshPoint> points = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 1}};
  const std::array<std::uint32_t, 4> corners = {0, 1, 2, 3};
  PolygonCutter cutter;
  cutter.cut(points, corners);
  const std::uint64_t before = testing::allocation_count();
  std::size_t triangles = 0;
  for (int i = 0; i < 100; ++i) triangles += cutter.cut(points, corners).size();
  EXPECT_EQ(testing::allocation_count(), before);
  EXPECT_EQ(triangles, 200u);
}

TEST(PolygonTriangles, SpiralsOfLongArmsAreRejectedBeforeTheyTakeLong) {
  // Out along one side of an arm of ten turns and more, and back along the other.
  const auto spiral = [](std::size_t side) {
    std::vector<MeshPoint> points(2 * side);
    for (std::size_t i = 0; i < side; ++i) {
      const double angle = 0.1 * static_cast<double>(i);
      const auto at = [angle](double radius) -> MeshPoint {
        return {static_cast<float>(radius * std::cos(angle)),
                static_cast<float>(radius * std::sin(angle)), 0};
      };
      points[i] = at(1 + angle);
      points[points.size() - 1 - i] = at(3 + angle);
    }
    std::vector<std::uint32_t> corners(points.size());
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
    return polygon_triangles(points, corners).size();
  };
  EXPECT_EQ(spiral(400), 798u);
  EXPECT_THROW(spiral(4000), Error);
}

}  // namespace
}  // namespace octavo
