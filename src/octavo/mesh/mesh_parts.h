// A mesh cut into parts: the triangles whose middles lie in the same cube.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// Where the cube of a part lies: z, y, x.
using MeshPartPlace = std::array<std::int32_t, 3>;

/// The triangles of all parts, one part after the other, ascending by their places.
struct PartTriangles {
  std::vector<std::uint32_t> order;
  std::vector<MeshPartPlace> places;
  std::vector<std::size_t> ends;      ///< behind the triangles of each part
  std::vector<std::uint8_t> is_seam;  ///< points that several parts have

  std::span<const std::uint32_t> of(std::size_t part) const {
    const std::size_t first = part == 0 ? 0 : ends[part - 1];
    return {order.data() + first, ends[part] - first};
  }
};

/// Of a mesh with triangles, taken from a grid. Uses the threads of the calling task arena.
/// side   of the cubes in voxels, above 0
/// shift  of the cubes, as a share of their side
PartTriangles cut_in_parts(const TriangleMesh& mesh, const Geometry& geometry, double side,
                           double shift);

}  // namespace octavo
