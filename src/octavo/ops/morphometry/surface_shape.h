// The area of the surface of a mask and how it bends, without a mesh, a few planes at a time.
//
// Every face between a voxel of the mask and one that is not stands for a patch of the smooth
// surface. A patch of area A with the unit normal n has faces of A * |n_a| along each axis a, so
//
//     A = sum over faces of  area of the face * |n_a|        since  n_x^2 + n_y^2 + n_z^2 = 1
//
// Normals are those of the mask averaged over 7 x 7 x 7 voxels, 5 along their long sides, of which
// the middle counts more where something thin passes. How much surfaces of equal averages bend,
// summed over patches, is how fast the area grows when the surface moves outward: second
// derivatives across the normal, over the gradient. None is taken along the normal, so that it
// does not matter how near the other side of a plate or gap is.
//
// Source  F. Flin et al., Adaptive Estimation of Normals and Surface Area for Discrete 3-D
//         Objects, IEEE Transactions on Image Processing 14 (2005)
#pragma once

#include <cstdint>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

struct SurfaceShape {
  double area_mm2 = 0;     ///< between the mask and what is not in it
  double growth_mm = 0;    ///< change of the area when all of it moves outward, mm2 per mm
  double cut_mm2 = 0;      ///< faces of the mask at the border of the volume or region

  SurfaceShape& operator+=(const SurfaceShape& other);
};

/// What a thread takes in measuring the surface: 210 bytes for each voxel of a plane.
std::uint64_t surface_shape_bytes(const Size3& size);

/// Measures the surface. Uses the threads of the calling task arena; does not depend on them.
/// region  only faces between two of its voxels count; null: all of the volume
/// Throws  Error{cancelled}
/// Memory  surface_shape_bytes, per thread
SurfaceShape surface_shape(const MaskTree& mask, const MaskTree* region, const Point3& spacing_mm,
                           Progress& progress);

}  // namespace octavo
