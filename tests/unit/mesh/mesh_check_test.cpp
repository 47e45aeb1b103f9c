#include "octavo/mesh/mesh_check.h"

#include <gtest/gtest.h>

#include "octavo/mesh/mesh_pieces.h"

namespace octavo {
namespace {

/// A tetrahedron with a corner at x, its triangles outward.
TriangleMesh tetrahedron(float x = 0) {
  return {{{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}, {x, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

/// Both meshes as one.
TriangleMesh together(TriangleMesh a, const TriangleMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (const MeshTriangle& t : b.triangles) {
    a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return a;
}

TEST(MeshCheck, OfABodyFindsNothing) {
  const MeshCheck check = check_mesh(tetrahedron());
  EXPECT_TRUE(check.is_closed());
  EXPECT_TRUE(check.is_manifold());
  EXPECT_EQ(check.components, 1u);
  EXPECT_EQ(check.euler_number, 2);
  EXPECT_DOUBLE_EQ(measure_mesh(tetrahedron()).volume_mm3, 1.0 / 6);
  EXPECT_NEAR(measure_mesh(tetrahedron()).area_mm2, 1.5 + 0.8660254, 1e-6);
}

TEST(MeshCheck, CountsTheSidesOfAHole) {
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.pop_back();
  EXPECT_EQ(check_mesh(mesh).open_sides, 3u);
}

TEST(MeshCheck, FindsATriangleThatIsTurnedRound) {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  const MeshCheck check = check_mesh(mesh);
  EXPECT_FALSE(check.is_closed());
  EXPECT_FALSE(check.is_manifold());
}

TEST(MeshCheck, FindsEdgesAndPointsWherePartsTouch) {
  // At a point: the second one begins where the first one ends.
  TriangleMesh at_point = together(tetrahedron(), tetrahedron(1));
  for (MeshTriangle& t : at_point.triangles) {
    for (std::uint32_t& point : t) point = point == 4 ? 1 : point;
  }
  const MeshCheck touching = check_mesh(at_point);
  EXPECT_TRUE(touching.is_closed());
  EXPECT_EQ(touching.pinched_points, 1u);
  EXPECT_EQ(touching.components, 1u);
  // All sides twice.
  const TriangleMesh one = tetrahedron();
  TriangleMesh twice = one;
  twice.triangles.insert(twice.triangles.end(), one.triangles.begin(), one.triangles.end());
  EXPECT_EQ(check_mesh(twice).repeated_sides, 12u);
}

TEST(MeshCheck, FindsPointsAtOnePlace) {
  const MeshCheck check = check_mesh(together(tetrahedron(), tetrahedron(1)));
  EXPECT_EQ(check.coincident_points, 1u);
  EXPECT_FALSE(check.is_manifold());
  EXPECT_EQ(check.components, 2u);
}

TEST(MeshPieces, AreTakenByAPointOfThem) {
  const TriangleMesh mesh = together(tetrahedron(), tetrahedron(5));
  const NearestTriangle nearest = nearest_triangle(mesh, {4, 0.1, 0.1});
  EXPECT_DOUBLE_EQ(nearest.distance_mm, 1);
  EXPECT_EQ(piece_of_point(mesh, mesh.triangles[nearest.triangle][0]), tetrahedron(5));
}

}  // namespace
}  // namespace octavo
