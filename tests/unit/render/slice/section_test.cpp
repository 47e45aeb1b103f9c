#include "octavo/render/slice/section.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"

namespace octavo {
namespace {

constexpr Size3 kSectionSize = {40, 30, 20};

/// A grid that lies askew.
Geometry turned_grid() {
  Geometry geometry;
  geometry.origin_mm = {-12.5, 40, 3};
  geometry.spacing_mm = {0.8, 1.1, 2.5};
  const double c = std::cos(0.4), s = std::sin(0.4);
  geometry.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  return geometry;
}

TEST(Section, PixelsOfASliceAreItsSamples) {
  const Geometry geometry = turned_grid();
  for (int axis = 0; axis < 3; ++axis) {
    const PlaneSection section = axis_section(geometry, kSectionSize, axis, 7, 1);
    const PixelMap map = index_map(section.world, geometry);
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{3.0, 5.0}}) {
      const auto a = static_cast<std::size_t>(axis);
      EXPECT_EQ(map.at(x, y)[a], 7);
      EXPECT_EQ(map.across[a], 0);
      EXPECT_EQ(map.down[a], 0);
    }
    const double pixels = static_cast<double>(section.width * section.height);
    double area = 1;
    for (int other = 0; other < 3; ++other) {
      if (other == axis) continue;
      area *=
          geometry.spacing_mm[static_cast<std::size_t>(other)] *
          static_cast<double>(kSectionSize[other]);
    }
    EXPECT_NEAR(pixels * section.pixel_mm * section.pixel_mm / area, 1, 0.05);
  }
}

TEST(Section, SmallPicturesAreEnlargedByAWholeNumber) {
  const PlaneSection plain = axis_section({}, kSectionSize, 2, 0, 1);
  EXPECT_EQ(plain.width, 40);
  EXPECT_EQ(plain.height, 30);
  const PlaneSection large = axis_section({}, kSectionSize, 2, 0, 100);
  EXPECT_EQ(large.width, 120);
  EXPECT_EQ(large.height, 90);
  EXPECT_DOUBLE_EQ(large.pixel_mm, 1.0 / 3);
}

TEST(Section, AnObliquePictureLiesInItsPlaneAndIsSquare) {
  const Geometry geometry = turned_grid();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int round = 0; round < 40; ++round) {
    const CutPlane plane{geometry.to_world({20 + 5 * any(random), 15, 10}),
                         {any(random), any(random), any(random)}};
    const PlaneSection section = oblique_section(geometry, kSectionSize, plane, 200);
    const double length = std::sqrt(dot(plane.normal, plane.normal));
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, std::pair{50.0, 9.0}, std::pair{3.0, 90.0}}) {
      const Point3 off = difference(section.world.at(x, y), plane.point_mm);
      EXPECT_NEAR(dot(off, plane.normal) / length, 0, 1e-9);
    }
    EXPECT_NEAR(std::sqrt(dot(section.world.across, section.world.across)), section.pixel_mm, 1e-9);
    EXPECT_NEAR(std::sqrt(dot(section.world.down, section.world.down)), section.pixel_mm, 1e-9);
    EXPECT_NEAR(dot(section.world.across, section.world.down), 0, 1e-9);
    EXPECT_GE(std::max(section.width, section.height), 200);
  }
}

TEST(Section, AnObliquePictureHoldsAllOfThePlaneAndNoMore) {
  const Geometry geometry = turned_grid();
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int round = 0; round < 40; ++round) {
    const CutPlane plane{geometry.to_world({20, 15, 10}), {any(random), any(random), any(random)}};
    const PlaneSection section = oblique_section(geometry, kSectionSize, plane, 300);
    const PixelMap map = index_map(section.world, geometry);
    const auto is_inside = [&](std::int64_t x, std::int64_t y) {
      const Point3 at = map.at(static_cast<double>(x), static_cast<double>(y));
      for (int a = 0; a < 3; ++a) {
        const double index = at[static_cast<std::size_t>(a)];
        if (index < -0.5 || index > static_cast<double>(kSectionSize[a]) - 0.5) return false;
      }
      return true;
    };
    // One pixel beyond the picture nothing is inside; close to each edge something is.
    std::vector<int> near(4);
    for (std::int64_t x = -1; x <= section.width; ++x) {
      EXPECT_FALSE(is_inside(x, -1) || is_inside(x, section.height));
      near[0] += is_inside(x, 3) ? 1 : 0;
      near[1] += is_inside(x, section.height - 4) ? 1 : 0;
    }
    for (std::int64_t y = -1; y <= section.height; ++y) {
      EXPECT_FALSE(is_inside(-1, y) || is_inside(section.width, y));
      near[2] += is_inside(3, y) ? 1 : 0;
      near[3] += is_inside(section.width - 4, y) ? 1 : 0;
    }
    for (const int count : near) EXPECT_GT(count, 0);
  }
}

TEST(Section, SpacingsThatMakeItTooFlatAreRejected) {
  Geometry geometry;
  for (const double flat : {1e-8, 1e-300}) {
    geometry.spacing_mm = {flat, 1, 1};
    EXPECT_THROW(axis_section(geometry, kSectionSize, 2, 0, 1), Error) << flat;
    EXPECT_THROW(oblique_section(geometry, kSectionSize, {{0, 15, 10}, {0, 0, 1}}, 1), Error)
        << flat;
    EXPECT_EQ(axis_section(geometry, kSectionSize, 0, 0, 1).width, kSectionSize.y);
  }
}

TEST(Section, ObliquePicturesAreSeenAsTheNearestSliceIs) {
  const auto letters = [](const Point3& normal) {
    return oblique_section({}, kSectionSize, {{20, 15, 10}, normal}, 1).letters;
  };
  for (const double sign : {1.0, -1.0}) {
    EXPECT_EQ(letters({0, 0, sign}), (EdgeLetters{"R", "L", "A", "P"}));
    EXPECT_EQ(letters({0, sign, 0}), (EdgeLetters{"R", "L", "S", "I"}));
    EXPECT_EQ(letters({sign, 0, 0}), (EdgeLetters{"A", "P", "S", "I"}));
    EXPECT_EQ(letters({0, 0.5 * sign, sign}), (EdgeLetters{"R", "L", "AS", "PI"}));
    EXPECT_EQ(letters({sign, 1.01 * sign, 0}), (EdgeLetters{"RP", "LA", "S", "I"}));
  }
}

TEST(Section, SlicesOfTurnedGridsHaveTheLettersOfTheirDirections) {
  const auto turned_by = [](double degrees) {
    const double c = std::cos(degrees * std::numbers::pi / 180);
    const double s = std::sin(degrees * std::numbers::pi / 180);
    Geometry geometry;
    geometry.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
    return geometry;
  };
  const Size3 size{20, 20, 20};
  const PlaneSection coronal = axis_section(turned_by(44), size, 1, 9, 1);
  EXPECT_EQ(coronal.letters, (EdgeLetters{"RA", "LP", "S", "I"}));
  const Geometry turned = turned_by(44);
  const Point3 normal = {turned.direction[1], turned.direction[4], turned.direction[7]};
  const PlaneSection oblique =
      oblique_section(turned, size, {turned.to_world({9, 9, 9}), normal}, 1);
  EXPECT_EQ(oblique.letters, coronal.letters);
  EXPECT_EQ(axis_section(turned_by(10), size, 1, 9, 1).letters,
            (EdgeLetters{"R", "L", "S", "I"}));
}

TEST(Section, WhatIsNoPlaneIsRejected) {
  const double nan = std::nan("");
  for (const CutPlane& plane : {CutPlane{{0, 0, 0}, {0, 0, 0}}, CutPlane{{0, 0, 0}, {nan, 0, 1}},
                                CutPlane{{nan, 0, 0}, {0, 0, 1}}, CutPlane{{0, 0, 19.6}, {0, 0, 1}},
                                CutPlane{{-30, 0, 0}, {1, 1, 1}}}) {
    EXPECT_THROW(oblique_section({}, kSectionSize, plane, 1), Error);
  }
  EXPECT_THROW(axis_section({}, kSectionSize, 3, 0, 1), Error);
  EXPECT_THROW(axis_section({}, kSectionSize, 1, 30, 1), Error);
}

}  // namespace
}  // namespace octavo
