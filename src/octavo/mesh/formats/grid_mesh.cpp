#include "octavo/mesh/formats/grid_mesh.h"

#include <cstddef>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

namespace {

/// Six times what each piece encloses.
std::vector<double> enclosed_by(const MeshPieces& pieces, const TriangleMesh& mesh) {
  const Point3 origin = place_of_point(mesh.points.front());
  std::vector<double> volumes(pieces.count);
  for (const MeshTriangle& t : mesh.triangles) {
    const Point3 a = difference(place_of_point(mesh.points[t[0]]), origin);
    const Point3 b = difference(place_of_point(mesh.points[t[1]]), origin);
    const Point3 c = difference(place_of_point(mesh.points[t[2]]), origin);
    volumes[pieces.of_point[t[0]]] += dot(a, cross(b, c));
  }
  return volumes;
}

}  // namespace

std::optional<TriangleMesh> mesh_on_grid(const TriangleMesh& mesh, const PointGrid& grid,
                                         const Progress& progress) {
  if (mesh.triangles.empty()) return mesh;
  TriangleMesh moved = mesh;
  grid.snap(moved);
  if (check_mesh(moved).coincident_points > 0) return std::nullopt;
  const MeshPieces pieces = mesh_pieces(mesh);
  const std::vector<double> before = enclosed_by(pieces, mesh);
  const std::vector<double> after = enclosed_by(pieces, moved);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!(before[i] * after[i] > 0)) return std::nullopt;
  }
  if (!crossing_triangles(TriangleTree(moved), progress).empty()) return std::nullopt;
  return moved;
}

}  // namespace octavo
