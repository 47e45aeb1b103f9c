// A picture of a pose: what was laid onto a mask over the shadow of the mask, from three sides.
#pragma once

#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/render/picture.h"

namespace octavo {

/// A place of what moved, in world space, and how far it is from the surface.
struct PosedPlace {
  Point3 place{};
  double mm = 0;
};

/// Views along the three axes of the grid. The mask is grey, lighter where more of it lies behind;
/// places are green within `near_mm`, yellow within twice that, red beyond. Places beside the
/// volume are cropped.
/// Memory  three planes of counts, four of voxels
Picture pose_picture(const MaskTree& mask, const Geometry& geometry,
                     const std::vector<PosedPlace>& places, double near_mm);

}  // namespace octavo
