// The balls that fit into one class of a mask: what local thickness is made of.
//
// A ball holds no center of a voxel of the other class. Its own center lies on a ridge of
// distances, anywhere in a voxel:
//
//     o  o  o  o  .        1  voxels on a ridge: their sites and those of a neighbor lie on
//     o  o  +  o  o  .        different sides
//     .  o  o  o  .        2  the place in the voxel that is farthest from all these sites
//                          3  the surface passes before the sites that the ball touches, by as much
//                             as what is around them says (site_lines.h)
//
// Where all that it touches is flat along axes, a ball reaches to the nearest face of a voxel; it
// is never smaller than that. So plates and square rods of w voxels are w voxels thick on any grid.
//
// The centers of voxels of the class that a ball holds are covered by it.
//
// Source  T. Hildebrand, P. Rüegsegger, A new method for the model-independent assessment of
//         thickness in three-dimensional images, Journal of Microscopy 185 (1997); W. H. Hesselink,
//         J. B. T. M. Roerdink, Euclidean skeletons of digital image and volume data in linear
//         time by the integer medial axis transform, IEEE Transactions on Pattern Analysis and
//         Machine Intelligence 30 (2008)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/ops/distance/site_field.h"

namespace octavo {

/// Voxels whose thickness is asked for.
struct ThicknessClass {
  const MaskTree& mask;
  const MaskTree* region = nullptr;  ///< that balls begin in and voxels are measured in; null: all
  bool is_background = false;        ///< of what is not in the mask
};

struct FittingBall {
  /// Center, in voxels from the corner of the volume: index + 0.5 is the center of a voxel.
  std::array<float, 3> center{};
  float radius_mm = 0;  ///< to the surface: half of the thickness
  float reach_mm = 0;   ///< it covers voxels whose centers are nearer
};

/// The spacing that thickness is measured with: voxels whose sides differ by less than 1e-3, as by
/// the digits that files round them to, are cubes of their volume. Of sites that are equally far
/// away none may seem nearer.
Point3 thickness_spacing(const Point3& spacing_mm);

/// The balls around the ridges of a class, the largest first.
/// field  of the mask, with this spacing
/// Uses the threads of the calling task arena; does not depend on them.
/// Throws  Error{io}, Error{cancelled}
/// Memory  20 bytes a ball and 18 planes of 8 bytes a voxel
std::vector<FittingBall> fitting_balls(const ThicknessClass& asked, const Point3& spacing_mm,
                                       const SiteField& field, Progress& progress);

}  // namespace octavo
