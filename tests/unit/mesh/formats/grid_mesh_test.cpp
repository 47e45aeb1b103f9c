#include "octavo/mesh/formats/grid_mesh.h"

#include <gtest/gtest.h>

#include "octavo/mesh/mesh_check.h"

namespace octavo {
namespace {

/// A tetrahedron of this size at x, its triangles outward, behind those of `mesh`.
void add_tetrahedron(TriangleMesh& mesh, float x, float size) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), {{x, 0, 0}, {x + size, 0, 0}, {x, size, 0}, {x, 0, size}});
  for (const MeshTriangle& t :
       {MeshTriangle{0, 2, 1}, MeshTriangle{0, 1, 3}, MeshTriangle{0, 3, 2},
        MeshTriangle{1, 2, 3}}) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

std::optional<TriangleMesh> on_grid(const TriangleMesh& mesh, double margin_mm) {
  return mesh_on_grid(mesh, PointGrid::around(mesh, margin_mm), NoProgress());
}

TEST(GridMesh, StaysCloseAndSound) {
  TriangleMesh mesh;
  add_tetrahedron(mesh, 0.1f, 10);
  add_tetrahedron(mesh, 20.3f, 0.7f);
  const auto moved = on_grid(mesh, 0.01);
  ASSERT_TRUE(moved);
  EXPECT_NE(*moved, mesh);
  EXPECT_EQ(check_mesh(*moved).coincident_points, 0u);
  EXPECT_NEAR(measure_mesh(*moved).volume_mm3, measure_mesh(mesh).volume_mm3, 0.1);
}

TEST(GridMesh, IsNothingWherePointsWouldMeet) {
  TriangleMesh mesh;
  add_tetrahedron(mesh, 0, 1000);
  add_tetrahedron(mesh, 2000, 0.001f);
  EXPECT_FALSE(on_grid(mesh, 0));
}

TEST(GridMesh, IsNothingWhereAPieceWouldBeFlat) {
  TriangleMesh mesh;
  add_tetrahedron(mesh, 0, 65535);
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  // Its tip falls into its base without meeting another point.
  mesh.points.insert(mesh.points.end(),
                     {{70000, 0, 0}, {70100, 0, 0}, {70000, 100, 0}, {70020, 20, 0.1f}});
  for (const MeshTriangle& t :
       {MeshTriangle{0, 2, 1}, MeshTriangle{0, 1, 3}, MeshTriangle{0, 3, 2},
        MeshTriangle{1, 2, 3}}) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  EXPECT_EQ(check_mesh(mesh).coincident_points, 0u);
  EXPECT_FALSE(on_grid(mesh, 0));
}

}  // namespace
}  // namespace octavo
