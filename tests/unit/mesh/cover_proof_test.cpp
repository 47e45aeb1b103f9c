#include "octavo/mesh/cover_proof.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"
#include "support/square_meshes.h"

namespace octavo {
namespace {

using testing::fine_square;

constexpr std::uint32_t kMiddlePoint = 40;  // of a fine square

bool is_proven(const TriangleMesh& surface, const TrianglePlaces& triangle, double distance,
               std::uint32_t near = kMiddlePoint) {
  const PointTriangles fans(surface);
  return CoverProof(surface, fans, distance).proves(triangle, near);
}

TEST(CoverProof, ProvesWhatIsCoveredWithinTheDistance) {
  const TrianglePlaces inside = {{{1, 1, 0.5}, {7, 1.5, 0.5}, {3.5, 6.5, 0.5}}};
  const TrianglePlaces turned = {inside[0], inside[2], inside[1]};
  for (const TrianglePlaces& triangle : {inside, turned}) {
    EXPECT_TRUE(is_proven(fine_square(0, false), triangle, 0.51));
    EXPECT_FALSE(is_proven(fine_square(0, false), triangle, 0.49));
  }
}

TEST(CoverProof, DoesNotProveWhereTheSurfaceEnds) {
  const TrianglePlaces beyond = {{{1, 1, 0}, {9, 1.5, 0}, {3.5, 6.5, 0}}};
  EXPECT_FALSE(is_proven(fine_square(0, false), beyond, 0.5));
  const TrianglePlaces around = {{{1.2, 1.2, 0}, {6.7, 1.5, 0}, {3.5, 6.7, 0}}};
  EXPECT_TRUE(is_proven(fine_square(0, false), around, 0.5));
  EXPECT_FALSE(is_proven(fine_square(0, true), around, 0.5, 10));
}

TEST(CoverProof, DoesNotProveWhatLiesElsewhere) {
  const TrianglePlaces away = {{{20, 1, 0}, {26, 1.5, 0}, {23, 6, 0}}};
  EXPECT_FALSE(is_proven(fine_square(0, false), away, 0.5));
}

TEST(CoverProof, LeavesOutWhatIsHighBesideTheTriangle) {
  TriangleMesh wall = fine_square(0, false);
  for (MeshPoint& point : wall.points) point[2] = point[0] > 6 ? 5 * (point[0] - 6) : 0;
  const TrianglePlaces before = {{{1, 1, 0}, {6.05, 2, 0}, {2, 6, 0}}};
  const TrianglePlaces under = {{{1, 1, 0}, {6.5, 2, 0}, {2, 6, 0}}};
  EXPECT_TRUE(is_proven(wall, before, 0.5));
  EXPECT_FALSE(is_proven(wall, under, 0.5));
}

TEST(CoverProof, DoesNotProveTrianglesWithoutAnArea) {
  const TrianglePlaces line = {{{1, 1, 0}, {3, 3, 0}, {6, 6, 0}}};
  EXPECT_FALSE(is_proven(fine_square(0, false), line, 0.5));
}

// Surfaces that rise and fold over at random, beside triangles at random.
TEST(CoverProof, ProvesNothingThatIsFar) {
  std::mt19937 random(20);
  std::uniform_real_distribution<float> share(0, 1);
  constexpr double kDistance = 0.4;
  constexpr int kSteps = 8;
  int proven = 0;
  for (int run = 0; run < 100; ++run) {
    TriangleMesh surface = fine_square(0, false);
    const float moved = run % 3 == 0 ? 0.9f : 0.3f;
    for (MeshPoint& point : surface.points) {
      for (float& coordinate : point) coordinate += moved * (share(random) - 0.5f);
    }
    const TriangleTree tree(surface);
    for (int i = 0; i < 20; ++i) {
      TrianglePlaces t;
      for (Point3& place : t) {
        place = {1.0 + 6 * share(random), 1.0 + 6 * share(random), 0.4 * (share(random) - 0.5)};
      }
      if (!is_proven(surface, t, kDistance)) continue;
      ++proven;
      for (int a = 0; a <= kSteps; ++a) {
        for (int b = 0; a + b <= kSteps; ++b) {
          const int c = kSteps - a - b;
          const Point3 place = scaled(sum(sum(scaled(t[0], a), scaled(t[1], b)), scaled(t[2], c)),
                                      1.0 / kSteps);
          EXPECT_LT(tree.nearest(place, 1).distance, kDistance + 1e-9);
        }
      }
    }
  }
  EXPECT_GT(proven, 100);
}

}  // namespace
}  // namespace octavo
