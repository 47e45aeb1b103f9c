#include "octavo/mesh/cube_cases.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

#include "octavo/core/vectors.h"
#include "octavo/mesh/triangle_crossing.h"

namespace octavo {
namespace {

using CutPlaces = std::array<Point3, 12>;

/// A place on each edge: `shares` of the way along it.
CutPlaces cut_places(const std::array<double, 12>& shares) {
  CutPlaces places;
  for (std::size_t edge = 0; edge < 12; ++edge) {
    const auto p = static_cast<double>(edge & 1);
    const auto q = static_cast<double>(edge >> 1 & 1);
    const double at = shares[edge];
    places[edge] = edge < 4 ? Point3{at, p, q} : edge < 8 ? Point3{p, at, q} : Point3{p, q, at};
  }
  return places;
}

TrianglePlaces corner_places(const CutPlaces& places, const CubeTriangle& t) {
  return {places[t[0]], places[t[1]], places[t[2]]};
}

/// Pairs of triangles of a case that cross.
int crossings(std::span<const CubeTriangle> triangles, const CutPlaces& places) {
  int count = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t j = i + 1; j < triangles.size(); ++j) {
      const CubeTriangle& a = triangles[i];
      const CubeTriangle& b = triangles[j];
      if (do_cross(corner_places(places, a), {a[0], a[1], a[2]}, corner_places(places, b),
                   {b[0], b[1], b[2]})) {
        ++count;
      }
    }
  }
  return count;
}

/// The corners at the ends of an edge.
std::pair<unsigned, unsigned> ends_of(unsigned edge) {
  const unsigned p = edge & 1;
  const unsigned q = edge >> 1 & 1;
  if (edge < 4) return {2 * p + 4 * q, 1 + 2 * p + 4 * q};
  if (edge < 8) return {p + 4 * q, 2 + p + 4 * q};
  return {p + 2 * q, 4 + p + 2 * q};
}

TEST(CubeCases, NoTrianglesCrossForAnyPlacesOfThePoints) {
  std::mt19937 random(11);
  for (unsigned inside = 0; inside < 256; ++inside) {
    const auto triangles = CubeCases::shared().triangles(static_cast<std::uint8_t>(inside));
    for (int number = 0; number < 200; ++number) {
      std::array<double, 12> shares{};
      for (double& share : shares) {
        const double at = static_cast<double>(random() >> 12) * 0x1p-20;
        // Anywhere, at one of the ends, or near them.
        const double end = at < 0.5 ? 1.0 / 256 : 255.0 / 256;
        share = number % 3 == 0 ? at : number % 3 == 1 ? end : end + (at - end) / 16;
      }
      ASSERT_EQ(crossings(triangles, cut_places(shares)), 0) << "case " << inside;
    }
    std::array<double, 12> middles;
    middles.fill(0.5);
    ASSERT_EQ(crossings(triangles, cut_places(middles)), 0) << "case " << inside;
  }
}

TEST(CubeCases, TrianglesJoinJustThePointsOfEdgesThatAreCut) {
  for (unsigned inside = 0; inside < 256; ++inside) {
    unsigned joined = 0;
    for (const CubeTriangle& t :
         CubeCases::shared().triangles(static_cast<std::uint8_t>(inside))) {
      for (const std::uint8_t edge : t) joined |= 1u << edge;
    }
    unsigned cut = 0;
    for (unsigned edge = 0; edge < 12; ++edge) {
      const auto [a, b] = ends_of(edge);
      if ((inside >> a & 1) != (inside >> b & 1)) cut |= 1u << edge;
    }
    EXPECT_EQ(joined, cut) << "case " << inside;
  }
}

/// The common face of two edges; 6 where there is none.
unsigned common_face(unsigned a, unsigned b) {
  const auto [a0, a1] = ends_of(a);
  const auto [b0, b1] = ends_of(b);
  const unsigned ones = a0 & a1 & b0 & b1;
  const unsigned zeros = ~(a0 | a1 | b0 | b1);
  for (unsigned axis = 0; axis < 3; ++axis) {
    if ((ones >> axis & 1) != 0) return 2 * axis + 1;
    if ((zeros >> axis & 1) != 0) return 2 * axis;
  }
  return 6;
}

TEST(CubeCases, SidesInsideACubeAreSharedAndLieInNoFace) {
  for (unsigned inside = 0; inside < 256; ++inside) {
    std::map<std::pair<unsigned, unsigned>, int> sides;
    for (const CubeTriangle& t :
         CubeCases::shared().triangles(static_cast<std::uint8_t>(inside))) {
      for (std::size_t k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
    }
    for (const auto& [side, count] : sides) {
      EXPECT_EQ(count, 1) << "case " << inside;
      const bool has_twin = sides.count({side.second, side.first}) != 0;
      EXPECT_NE(has_twin, common_face(side.first, side.second) < 6) << "case " << inside;
    }
  }
}

TEST(CubeCases, TrianglesFaceAwayFromALoneInsideCorner) {
  std::array<double, 12> middles;
  middles.fill(0.5);
  const CutPlaces places = cut_places(middles);
  for (unsigned corner = 0; corner < 8; ++corner) {
    const auto triangles = CubeCases::shared().triangles(static_cast<std::uint8_t>(1u << corner));
    ASSERT_EQ(triangles.size(), 1u);
    const TrianglePlaces t = corner_places(places, triangles[0]);
    const Point3 at = {static_cast<double>(corner & 1), static_cast<double>(corner >> 1 & 1),
                       static_cast<double>(corner >> 2 & 1)};
    const Point3 normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
    EXPECT_GT(dot(normal, difference(t[0], at)), 0) << "corner " << corner;
  }
}

}  // namespace
}  // namespace octavo
