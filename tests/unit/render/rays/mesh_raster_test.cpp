#include "octavo/render/rays/mesh_raster.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <vector>

namespace octavo {
namespace {

constexpr PixelSquare kSquare = {0, 0, 32};

/// How often each place of each pixel is covered.
class Coverage {
 public:
  void add(std::vector<ScreenPoint> corners) {
    visit_covered(corners, kSquare, [&](std::int64_t column, std::int64_t row,
                                        std::uint32_t mask) {
      for (int place = 0; place < kPlacesInPixel; ++place) {
        const std::int64_t pixel = row * kSquare.side + column;
        if (mask >> place & 1) ++counts_[static_cast<std::size_t>(pixel * kPlacesInPixel + place)];
      }
    });
  }
  const std::vector<int>& counts() const { return counts_; }

 private:
  std::vector<int> counts_ =
      std::vector<int>(static_cast<std::size_t>(kSquare.side * kSquare.side * kPlacesInPixel));
};

TEST(MeshRaster, AFanAroundAPointCoversEachPlaceOnce) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> inside(4, 28);
  for (int round = 0; round < 200; ++round) {
    // Some corners on places, where edges run through many of them.
    const bool is_on_places = round % 2 == 0;
    ScreenPoint middle = {inside(random), inside(random)};
    if (is_on_places) middle = {std::floor(middle.x) + 8 / 256.0, std::floor(middle.y) + 0.5};
    const ScreenPoint frame[] = {{-5, -5}, {16 + 8 / 256.0, -5}, {40, -5}, {40, 40}, {-5, 40}};
    Coverage coverage;
    for (std::size_t i = 0; i < std::size(frame); ++i) {
      coverage.add({middle, frame[i], frame[(i + 1) % std::size(frame)]});
    }
    for (const int count : coverage.counts()) ASSERT_EQ(count, 1) << "round " << round;
  }
}

TEST(MeshRaster, CoverageIsTheAreaWhicheverWayRound) {
  for (const double angle : {0.1, 0.7, 1.3}) {
    std::vector<ScreenPoint> corners;
    for (int i = 0; i < 3; ++i) {
      const double at = angle + i * 2.0943951;
      corners.push_back({16 + 12 * std::cos(at), 16 + 12 * std::sin(at)});
    }
    Coverage one;
    one.add(corners);
    Coverage other;
    other.add({corners[2], corners[1], corners[0]});
    EXPECT_EQ(one.counts(), other.counts());
    double places = 0;
    for (const int count : one.counts()) places += count;
    EXPECT_NEAR(places / kPlacesInPixel, 12 * 12 * 1.2990381, 0.5);
  }
}

TEST(MeshRaster, WhatHasNoAreaCoversNothing) {
  Coverage coverage;
  coverage.add({{1, 1}, {20, 20}, {10, 10}});
  coverage.add({{1, 1}, {1, 1}, {10, 20}});
  for (const int count : coverage.counts()) ASSERT_EQ(count, 0);
}

TEST(MeshRaster, ACornerTwiceChangesNothing) {
  Coverage three;
  three.add({{2, 3}, {30, 8}, {9, 25}});
  Coverage four;
  four.add({{2, 3}, {30, 8}, {30, 8}, {9, 25}});
  EXPECT_EQ(three.counts(), four.counts());
}

}  // namespace
}  // namespace octavo
