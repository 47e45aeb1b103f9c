#include "octavo/mesh/cube_cases.h"

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/triangle_crossing.h"

namespace octavo {

namespace {

using Loop = std::vector<std::uint8_t>;
using CubeTriangles = std::vector<CubeTriangle>;

/// Corners of the faces, counterclockwise as seen from outside.
constexpr std::uint8_t kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                       {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/// The edge between two corners.
std::uint8_t edge_between(unsigned a, unsigned b) {
  const unsigned low = a & b;
  const unsigned x = low & 1;
  const unsigned y = low >> 1 & 1;
  const unsigned z = low >> 2 & 1;
  switch (a ^ b) {
    case 1: return static_cast<std::uint8_t>(y + 2 * z);
    case 2: return static_cast<std::uint8_t>(4 + x + 2 * z);
    default: return static_cast<std::uint8_t>(8 + x + 2 * y);
  }
}

/// The two faces that meet at an edge, as bits 2 * axis + side.
unsigned faces_at(unsigned edge) {
  const unsigned p = edge & 1;
  const unsigned q = edge >> 1 & 1;
  const unsigned axis = edge / 4;
  const unsigned first = axis == 0 ? 1 : 0;
  const unsigned second = axis == 2 ? 1 : 2;
  return 1u << (2 * first + p) | 1u << (2 * second + q);
}

/// The closed lines in which a surface leaves the faces of a cube. On each face it runs from where
/// a run of inside corners begins to where that run ends.
std::vector<Loop> loops_of(unsigned inside) {
  constexpr std::uint8_t kNone = 0xff;
  std::array<std::uint8_t, 12> next{};
  next.fill(kNone);
  const auto is_inside = [&](unsigned corner) { return (inside >> corner & 1) != 0; };
  for (const auto& face : kFaces) {
    for (unsigned i = 0; i < 4; ++i) {
      if (!is_inside(face[i]) || is_inside(face[(i + 1) % 4])) continue;
      unsigned before = i;
      while (is_inside(face[before])) before = (before + 3) % 4;
      next[edge_between(face[before], face[(before + 1) % 4])] =
          edge_between(face[i], face[(i + 1) % 4]);
    }
  }
  std::vector<Loop> loops;
  for (std::uint8_t edge = 0; edge < 12; ++edge) {
    Loop loop;
    for (std::uint8_t at = edge; next[at] != kNone;) {
      loop.push_back(at);
      const std::uint8_t following = next[at];
      next[at] = kNone;
      at = following;
    }
    if (!loop.empty()) loops.push_back(loop);
  }
  return loops;
}

/// Whether corners i and j of a loop may be joined: they are neighbors, or on no common face.
bool may_join(const Loop& loop, std::size_t i, std::size_t j) {
  const bool are_ends = i == 0 && j == loop.size() - 1;
  return j - i == 1 || are_ends || (faces_at(loop[i]) & faces_at(loop[j])) == 0;
}

/// All triangulations of the part first .. last of a loop.
std::vector<CubeTriangles> triangulations(const Loop& loop, std::size_t first, std::size_t last) {
  if (last - first < 2) return {{}};
  std::vector<CubeTriangles> all;
  for (std::size_t middle = first + 1; middle < last; ++middle) {
    if (!may_join(loop, first, middle) || !may_join(loop, middle, last)) continue;
    const std::vector<CubeTriangles> after = triangulations(loop, middle, last);
    for (const CubeTriangles& left : triangulations(loop, first, middle)) {
      for (const CubeTriangles& right : after) {
        CubeTriangles& both = all.emplace_back(left);
        both.insert(both.end(), right.begin(), right.end());
        both.push_back({loop[first], loop[middle], loop[last]});
      }
    }
  }
  return all;
}

/// Every way to take one triangulation of each loop.
std::vector<CubeTriangles> combinations(const std::vector<Loop>& loops) {
  std::vector<CubeTriangles> all = {{}};
  for (const Loop& loop : loops) {
    std::vector<CubeTriangles> longer;
    for (const CubeTriangles& right : triangulations(loop, 0, loop.size() - 1)) {
      for (const CubeTriangles& left : all) {
        longer.push_back(left);
        longer.back().insert(longer.back().end(), right.begin(), right.end());
      }
    }
    all = std::move(longer);
  }
  return all;
}

/// A place on each edge of the cube.
using EdgePlaces = std::array<Point3, 12>;

std::vector<EdgePlaces> tried_places() {
  constexpr int kTries = 16;
  constexpr double kNearEnd = 0x1p-8;
  std::mt19937 random(7);
  std::vector<EdgePlaces> tries(kTries);
  for (int number = 0; number < kTries; ++number) {
    for (std::size_t edge = 0; edge < 12; ++edge) {
      double at = static_cast<double>(random() >> 12) * 0x1p-20;
      if (number % 2 == 1) at = at < 0.5 ? kNearEnd : 1 - kNearEnd;
      const auto p = static_cast<double>(edge & 1);
      const auto q = static_cast<double>(edge >> 1 & 1);
      tries[static_cast<std::size_t>(number)][edge] =
          edge < 4 ? Point3{at, p, q} : edge < 8 ? Point3{p, at, q} : Point3{p, q, at};
    }
  }
  return tries;
}

bool do_any_cross(const CubeTriangles& triangles, const EdgePlaces& places) {
  const auto places_of = [&](const CubeTriangle& t) {
    return TrianglePlaces{places[t[0]], places[t[1]], places[t[2]]};
  };
  const auto numbers_of = [](const CubeTriangle& t) { return MeshTriangle{t[0], t[1], t[2]}; };
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t j = i + 1; j < triangles.size(); ++j) {
      if (do_cross(places_of(triangles[i]), numbers_of(triangles[i]), places_of(triangles[j]),
                   numbers_of(triangles[j]))) {
        return true;
      }
    }
  }
  return false;
}

CubeTriangles best_of(const std::vector<CubeTriangles>& all,
                      const std::vector<EdgePlaces>& tries) {
  for (const CubeTriangles& one : all) {
    const auto crosses = [&](const EdgePlaces& places) { return do_any_cross(one, places); };
    if (all.size() == 1 || std::none_of(tries.begin(), tries.end(), crosses)) return one;
  }
  throw Error(ErrorKind::internal, "a case of marching cubes has no triangles that fit");
}

}  // namespace

CubeCases::CubeCases() {
  const std::vector<EdgePlaces> tries = tried_places();
  for (unsigned inside = 0; inside < 256; ++inside) {
    const CubeTriangles best = best_of(combinations(loops_of(inside)), tries);
    if (best.size() > kMostTriangles) {
      throw Error(ErrorKind::internal, "a case of marching cubes has too many triangles");
    }
    std::copy(best.begin(), best.end(), triangles_[inside].begin());
    counts_[inside] = static_cast<std::uint8_t>(best.size());
  }
}

const CubeCases& CubeCases::shared() {
  static const CubeCases cases;
  return cases;
}

}  // namespace octavo
