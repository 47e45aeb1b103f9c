#include "octavo/mesh/mesh_pieces.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include "octavo/core/joined_sets.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

MeshPieces mesh_pieces(const TriangleMesh& mesh) {
  JoinedSets<std::uint32_t> joined(mesh.points.size());
  std::vector<bool> is_used(mesh.points.size());
  for (const MeshTriangle& t : mesh.triangles) {
    joined.join(t[0], t[1]);
    joined.join(t[0], t[2]);
    for (const std::uint32_t point : t) is_used[point] = true;
  }
  MeshPieces pieces;
  pieces.of_point.assign(mesh.points.size(), MeshPieces::kNone);
  for (std::uint32_t i = 0; i < mesh.points.size(); ++i) {
    if (!is_used[i]) continue;
    const std::uint32_t first = joined.first_of(i);
    if (first == i) pieces.of_point[i] = static_cast<std::uint32_t>(pieces.count++);
    else pieces.of_point[i] = pieces.of_point[first];
  }
  return pieces;
}

NearestTriangle nearest_triangle(const TriangleMesh& mesh, const Point3& place) {
  NearestTriangle nearest;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const double squared = squared_distance(place, places_of(mesh, mesh.triangles[i]));
    if (squared >= best) continue;
    best = squared;
    nearest.triangle = static_cast<std::uint32_t>(i);
  }
  nearest.distance_mm = std::sqrt(best);
  return nearest;
}

TriangleMesh piece_of_point(const TriangleMesh& mesh, std::uint32_t point) {
  const MeshPieces pieces = mesh_pieces(mesh);
  const std::uint32_t wanted = pieces.of_point[point];
  std::vector<std::uint32_t> numbers(mesh.points.size());
  TriangleMesh piece;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (pieces.of_point[i] != wanted) continue;
    numbers[i] = static_cast<std::uint32_t>(piece.points.size());
    piece.points.push_back(mesh.points[i]);
  }
  for (const MeshTriangle& t : mesh.triangles) {
    if (pieces.of_point[t[0]] != wanted) continue;
    piece.triangles.push_back({numbers[t[0]], numbers[t[1]], numbers[t[2]]});
  }
  return piece;
}

}  // namespace octavo
