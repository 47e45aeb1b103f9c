// The triangles around each point of a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// Immutable. Memory 8 bytes per point and 12 per triangle.
class PointTriangles {
 public:
  explicit PointTriangles(const TriangleMesh& mesh);

  /// Numbers of triangles, ascending.
  std::span<const std::uint32_t> of(std::uint32_t point) const {
    return {triangles_.data() + ends_[point], triangles_.data() + ends_[point + std::size_t{1}]};
  }

 private:
  std::vector<std::size_t> ends_;  // behind the triangles of the point before
  std::vector<std::uint32_t> triangles_;
};

}  // namespace octavo
