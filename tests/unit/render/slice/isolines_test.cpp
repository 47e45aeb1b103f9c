#include "octavo/render/slice/isolines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

namespace octavo {
namespace {

SectionSamples random_field(std::int64_t width, std::int64_t height, std::mt19937& random,
                            int steps) {
  SectionSamples field{width, height, {}};
  for (std::int64_t i = 0; i < width * height; ++i) {
    field.values.push_back(static_cast<double>(random() % static_cast<unsigned>(steps)));
  }
  return field;
}

/// A side of a cell: its upper or left pixel, and whether it leads down.
using Side = std::pair<std::pair<std::int64_t, std::int64_t>, bool>;

/// The sides that a level crosses, with the places of the crossings; those of cells alone.
std::map<Side, PixelPoint> crossings(const SectionSamples& field, double level) {
  std::map<Side, PixelPoint> found;
  for (std::int64_t y = 0; y < field.height; ++y) {
    for (std::int64_t x = 0; x < field.width; ++x) {
      for (const bool is_down : {false, true}) {
        const std::int64_t u = x + (is_down ? 0 : 1), v = y + (is_down ? 1 : 0);
        if (u >= field.width || v >= field.height) continue;
        const double a = field.at(x, y), b = field.at(u, v);
        if ((a < level) == (b < level)) continue;
        const double share = (level - a) / (b - a);
        found[{{x, y}, is_down}] = {static_cast<double>(x) + (is_down ? 0 : share),
                                    static_cast<double>(y) + (is_down ? share : 0)};
      }
    }
  }
  return found;
}

TEST(Isolines, PassEveryCrossedSideOnceAndNoOther) {
  std::mt19937 random(2);
  for (int round = 0; round < 50; ++round) {
    const SectionSamples field = random_field(13, 11, random, round % 2 == 0 ? 3 : 100);
    const double level = round % 2 == 0 ? 1 : 47.3;
    std::multiset<std::pair<double, double>> expected, found;
    for (const auto& [side, point] : crossings(field, level)) expected.insert({point.x, point.y});
    for (const Isoline& line : isolines(field, level)) {
      const bool is_closed = line.size() > 1 && line.front() == line.back();
      for (std::size_t i = is_closed ? 1 : 0; i < line.size(); ++i) {
        found.insert({line[i].x, line[i].y});
      }
    }
    // A line that begins and ends at one point of the border counts it once.
    std::set<std::pair<double, double>> expected_places(expected.begin(), expected.end());
    std::set<std::pair<double, double>> found_places(found.begin(), found.end());
    EXPECT_EQ(found_places, expected_places);
    if (round % 2 != 0) {
      EXPECT_EQ(found, expected);
    }
  }
}

/// The plain table of marching squares: the pieces of line in each cell.
using Piece = std::pair<std::pair<double, double>, std::pair<double, double>>;

std::multiset<Piece> pieces_of_cells(const SectionSamples& field, double level) {
  const auto places = crossings(field, level);
  std::multiset<Piece> pieces;
  const auto add = [&](const Side& a, const Side& b) {
    const PixelPoint p = places.at(a), q = places.at(b);
    std::pair<double, double> from{p.x, p.y}, to{q.x, q.y};
    if (to < from) std::swap(from, to);
    pieces.insert({from, to});
  };
  for (std::int64_t y = 0; y + 1 < field.height; ++y) {
    for (std::int64_t x = 0; x + 1 < field.width; ++x) {
      const double v[] = {field.at(x, y), field.at(x + 1, y), field.at(x, y + 1),
                          field.at(x + 1, y + 1)};
      const Side top{{x, y}, false}, left{{x, y}, true}, bottom{{x, y + 1}, false},
          right{{x + 1, y}, true};
      const int bits = (v[0] < level ? 1 : 0) | (v[1] < level ? 2 : 0) | (v[2] < level ? 4 : 0) |
                       (v[3] < level ? 8 : 0);
      const bool is_low = (v[0] + v[1] + v[2] + v[3]) / 4 < level;
      switch (bits) {
        case 1:
        case 14: add(top, left); break;
        case 2:
        case 13: add(top, right); break;
        case 4:
        case 11: add(bottom, left); break;
        case 8:
        case 7: add(bottom, right); break;
        case 3:
        case 12: add(left, right); break;
        case 5:
        case 10: add(top, bottom); break;
        case 9:  // the low corners are upper left and lower right
          add(top, is_low ? right : left);
          add(bottom, is_low ? left : right);
          break;
        case 6:
          add(top, is_low ? left : right);
          add(bottom, is_low ? right : left);
          break;
        default: break;
      }
    }
  }
  return pieces;
}

TEST(Isolines, AreThoseOfMarchingSquares) {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    const SectionSamples field = random_field(12, 17, random, 1000);
    const double level = 100 + 13.37 * round;
    std::multiset<Piece> found;
    for (const Isoline& line : isolines(field, level)) {
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        std::pair<double, double> from{line[i].x, line[i].y}, to{line[i + 1].x, line[i + 1].y};
        if (to < from) std::swap(from, to);
        found.insert({from, to});
      }
    }
    EXPECT_EQ(found, pieces_of_cells(field, level));
  }
}

TEST(Isolines, OfACircleIsOneClosedLine) {
  SectionSamples field{41, 41, {}};
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) field.values.push_back(std::hypot(x - 20, y - 20));
  }
  const std::vector<Isoline> lines = isolines(field, 13);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_EQ(lines[0].front(), lines[0].back());
  for (const PixelPoint& point : lines[0]) {
    EXPECT_NEAR(std::hypot(point.x - 20, point.y - 20), 13, 0.03);
  }
  EXPECT_TRUE(isolines(field, 1000).empty());
}

TEST(Isolines, EndBesideWhatIsNoNumber) {
  SectionSamples field{9, 9, {}};
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      field.values.push_back(x == 4 && y == 4 ? std::numeric_limits<double>::quiet_NaN() : y);
    }
  }
  const std::vector<Isoline> lines = isolines(field, 4.5);
  ASSERT_EQ(lines.size(), 2u);
  for (const Isoline& line : lines) EXPECT_EQ(line.size(), 4u);
}

TEST(RoundLevels, AreRoundAndInside) {
  EXPECT_EQ(round_levels(0, 60, 6), (std::vector<double>{10, 20, 30, 40, 50}));
  EXPECT_EQ(round_levels(-1000, 3000, 6), (std::vector<double>{0, 1000, 2000}));
  EXPECT_EQ(round_levels(0, 1, 1).size(), 1u);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-4, 4);
  for (int round = 0; round < 500; ++round) {
    const double low = any(random) * std::pow(10, any(random));
    const double high = low + std::pow(10, any(random));
    for (const int most : {1, 4, 9}) {
      const std::vector<double> levels = round_levels(low, high, most);
      EXPECT_LE(levels.size(), static_cast<std::size_t>(most));
      for (const double level : levels) {
        EXPECT_GT(level, low);
        EXPECT_LT(level, high);
      }
      if (most >= 4) {
        EXPECT_GE(levels.size(), 1u);
      }
    }
  }
  EXPECT_TRUE(round_levels(5, 5, 4).empty());
  EXPECT_TRUE(round_levels(5, std::nan(""), 4).empty());
}

}  // namespace
}  // namespace octavo
