// A surface of triangles: what mesh makes, and what is written, checked and drawn.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace octavo {

/// A place in world space, mm.
using MeshPoint = std::array<float, 3>;

/// Numbers of three points, counterclockwise where the surface is seen from outside.
using MeshTriangle = std::array<std::uint32_t, 3>;

struct TriangleMesh {
  std::vector<MeshPoint> points;
  std::vector<MeshTriangle> triangles;

  bool operator==(const TriangleMesh&) const = default;
  std::uint64_t memory_bytes() const noexcept {
    return points.capacity() * sizeof(MeshPoint) + triangles.capacity() * sizeof(MeshTriangle);
  }
};

}  // namespace octavo
