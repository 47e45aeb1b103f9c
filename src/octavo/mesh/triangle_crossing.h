// Whether two triangles of a surface have points in common that they should not have.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

using TrianglePlaces = std::array<Point3, 3>;

/// True when the triangles have a point in common besides the corners and the edge they share by
/// number: touching counts. Exact for coordinates that are floats.
bool do_cross(const TrianglePlaces& a, const MeshTriangle& a_numbers, const TrianglePlaces& b,
              const MeshTriangle& b_numbers);

}  // namespace octavo
