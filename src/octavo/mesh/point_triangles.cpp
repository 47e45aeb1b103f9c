#include "octavo/mesh/point_triangles.h"

namespace octavo {

PointTriangles::PointTriangles(const TriangleMesh& mesh)
    : ends_(mesh.points.size() + 2), triangles_(3 * mesh.triangles.size()) {
  for (const MeshTriangle& t : mesh.triangles) {
    for (const std::uint32_t point : t) ++ends_[point + std::size_t{2}];
  }
  for (std::size_t i = 2; i < ends_.size(); ++i) ends_[i] += ends_[i - 1];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t point : mesh.triangles[i]) {
      triangles_[ends_[point + std::size_t{1}]++] = static_cast<std::uint32_t>(i);
    }
  }
}

}  // namespace octavo
