// The pieces of a surface that hang together.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

struct MeshPieces {
  std::uint64_t count = 0;
  /// Of each point: the piece it belongs to, from 0; of points that no triangle has, kNone.
  std::vector<std::uint32_t> of_point;

  static constexpr std::uint32_t kNone = 0xffffffff;
};

/// Pieces in the order of their first points.
MeshPieces mesh_pieces(const TriangleMesh& mesh);

/// Where a surface comes nearest to a place.
struct NearestTriangle {
  std::uint32_t triangle = 0;
  double distance_mm = 0;
};

/// Requires a mesh that is not empty.
NearestTriangle nearest_triangle(const TriangleMesh& mesh, const Point3& place);

/// The piece that a point belongs to, points and triangles in their order.
TriangleMesh piece_of_point(const TriangleMesh& mesh, std::uint32_t point);

}  // namespace octavo
