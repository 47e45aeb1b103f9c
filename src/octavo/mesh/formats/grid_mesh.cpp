#include "octavo/mesh/formats/grid_mesh.h"

#include <cstddef>
#include <vector>

#include "octavo/mesh/enclosed_volumes.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

std::optional<TriangleMesh> mesh_on_grid(const TriangleMesh& mesh, const PointGrid& grid,
                                         const Progress& progress) {
  if (mesh.triangles.empty()) return mesh;
  TriangleMesh moved = mesh;
  grid.snap(moved);
  if (check_mesh(moved).coincident_points > 0) return std::nullopt;
  const MeshPieces pieces = mesh_pieces(mesh);
  const auto piece_of = [&](std::size_t i) { return pieces.of_point[mesh.triangles[i][0]]; };
  const std::vector<double> before = volumes_of_groups(mesh, pieces.count, piece_of);
  const std::vector<double> after = volumes_of_groups(moved, pieces.count, piece_of);
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!(before[i] * after[i] > 0)) return std::nullopt;
  }
  if (!crossing_triangles(TriangleTree(moved), progress).empty()) return std::nullopt;
  return moved;
}

}  // namespace octavo
