#include "octavo/mesh/hexahedra/hex_fan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "octavo/mesh/hexahedra/hex_nodes.h"

namespace octavo {
namespace {

using Place = std::array<int, 3>;

Place place_of_number(int number) { return {number % 3, number / 3 % 3, number / 9}; }

int sixfold_volume(const Place& a, const Place& b, const Place& c, const Place& d) {
  const auto minus = [&](const Place& p) { return Place{p[0] - a[0], p[1] - a[1], p[2] - a[2]}; };
  const Place u = minus(b);
  const Place v = minus(c);
  const Place w = minus(d);
  return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
         u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/// The bases of the elements of a face, as sets of points.
std::set<std::set<int>> bases_of(std::uint32_t points, int face) {
  std::set<std::set<int>> bases;
  for (const FanElement& element : fan_of(points)) {
    if (element.face != face) continue;
    const int corners = point_count(element.shape) - 1;
    bases.insert({element.points.begin(), element.points.begin() + corners});
  }
  return bases;
}

/// Any middles of edges, of a face only with at least two of its edges: as smaller cubes give them.
std::vector<std::uint32_t> some_points() {
  std::vector<std::uint32_t> all;
  std::uint32_t state = 1;
  for (int i = 0; i < 3000; ++i) {
    std::uint32_t points = HexNodes::kCornerPoints;
    for (const std::uint32_t middle : {1u, 3u, 5u, 7u, 9u, 11u, 15u, 17u, 19u, 21u, 23u, 25u, 4u,
                                       10u, 12u, 14u, 16u, 22u}) {
      state = state * 1664525 + 1013904223;
      if (state >> 31 != 0) points |= 1u << middle;
    }
    all.push_back(points);
  }
  return all;
}

TEST(HexFan, EveryElementHasVolumeAndAllFillTheCube) {
  for (const std::uint32_t points : some_points()) {
    int sum = 0;
    for (const FanElement& e : fan_of(points)) {
      std::array<Place, 5> p{};
      for (std::size_t i = 0; i < 5; ++i) p[i] = place_of_number(e.points[i]);
      const auto top = static_cast<std::size_t>(point_count(e.shape) - 1);
      const int volume = sixfold_volume(p[0], p[1], p[2], p[top]);
      EXPECT_GT(volume, 0);
      sum += volume;
      if (e.shape == HexShape::pyramid) {
        EXPECT_EQ(sixfold_volume(p[0], p[2], p[3], p[top]), volume);
        sum += volume;
      }
      EXPECT_EQ(e.points[top], kFanCenter);
      for (std::size_t i = 0; i < top; ++i) EXPECT_NE(points >> e.points[i] & 1, 0u);
    }
    EXPECT_EQ(sum, 6 * 8);
  }
}

TEST(HexFan, EveryPointOnTheBorderIsUsed) {
  for (const std::uint32_t points : some_points()) {
    std::uint32_t used = 0;
    for (const FanElement& element : fan_of(points)) {
      const int corners = point_count(element.shape) - 1;
      for (int i = 0; i < corners; ++i) used |= 1u << element.points[static_cast<std::size_t>(i)];
    }
    EXPECT_EQ(used, points);
  }
}

TEST(HexFan, TwoCubesDivideTheFaceBetweenThemAlike) {
  constexpr std::array<int, 3> kStep = {1, 3, 9};
  for (const std::uint32_t points : some_points()) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int face = 2 * static_cast<int>(axis);
      // The cube before this one sees the same points on its upper face.
      std::uint32_t beside = HexNodes::kCornerPoints;
      for (int i = 0; i < 27; ++i) {
        if (place_of_number(i)[axis] == 0 && (points >> i & 1) != 0) {
          beside |= 1u << (i + 2 * kStep[axis]);
        }
      }
      std::set<std::set<int>> moved;
      for (const std::set<int>& base : bases_of(beside, face + 1)) {
        std::set<int> other;
        for (const int point : base) other.insert(point - 2 * kStep[axis]);
        moved.insert(other);
      }
      EXPECT_EQ(bases_of(points, face), moved);
    }
  }
}

TEST(HexFan, ACubeWithoutMiddlesIsSixPyramids) {
  const std::vector<FanElement> elements = fan_of(HexNodes::kCornerPoints);
  EXPECT_EQ(elements.size(), 6u);
  EXPECT_TRUE(std::all_of(elements.begin(), elements.end(), [](const FanElement& element) {
    return element.shape == HexShape::pyramid;
  }));
}

TEST(HexFan, ALoneQuarterIsOneWithoutTheMiddlesOfOppositeEdges) {
  const std::uint32_t corners = HexNodes::kCornerPoints;
  EXPECT_FALSE(has_lone_quarter(corners));
  EXPECT_FALSE(has_lone_quarter(corners | 1u << 1 | 1u << 3));
  EXPECT_TRUE(has_lone_quarter(corners | 1u << 1 | 1u << 3 | 1u << 4));
  EXPECT_FALSE(has_lone_quarter(corners | 1u << 1 | 1u << 3 | 1u << 7 | 1u << 4));
}

}  // namespace
}  // namespace octavo
