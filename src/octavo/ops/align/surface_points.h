// Points on the surface of a mask or a mesh, spread evenly over its faces.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/align/sight_lines.h"

namespace octavo {

/// About `count` middles of faces between the mask and what is not in it, in world space, or all
/// where there are fewer; faces at the border of the volume are none. In an order in which any
/// first part of them is spread over all of the surface. Depends on the mask alone.
/// Memory  4 planes of bytes, 24 bytes a point
std::vector<Point3> surface_points(const MaskTree& mask, const Geometry& geometry,
                                   std::int64_t count);

/// About `count` places on the triangles of a mesh, as many as they have of its area, in such an
/// order. Depends on the mesh alone.
std::vector<Point3> surface_points(const TriangleMesh& mesh, std::int64_t count);

/// `count` of the points, or all where there are fewer, in such an order.
std::vector<Point3> spread_points(std::vector<Point3> points, std::int64_t count);
/// The same of lines.
std::vector<SightLine> spread_lines(std::vector<SightLine> lines, std::int64_t count);

}  // namespace octavo
