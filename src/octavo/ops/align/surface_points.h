// Points on the surface of a mask, spread evenly over its faces.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// About `count` middles of faces between the mask and what is not in it, in world space, or all
/// where there are fewer; faces at the border of the volume are none. In an order in which any
/// first part of them is spread over all of the surface. Depends on the mask alone.
/// Memory  4 planes of bytes, 24 bytes a point
std::vector<Point3> surface_points(const MaskTree& mask, const Geometry& geometry,
                                   std::int64_t count);

}  // namespace octavo
