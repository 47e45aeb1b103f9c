// How far one gets in a direction before a surface is met: the mean intercept length, and the
// ellipsoid that says how it depends on direction.
//
// Parallel lines in each of many directions are sampled at steps of the largest
// spacing; every change between mask
// and background is an intercept. With L the length of all lines of a direction and I their
// intercepts, (I / L)^2 = u^T M u is fitted by least squares over the unit vectors u. The
// eigenvalues of M are the inverse squares of the axes of the ellipsoid.
//
// Source  W. J. Whitehouse, The quantitative morphology of anisotropic trabecular bone, Journal of
//         Microscopy 101 (1974); T. P. Harrigan, R. W. Mann, Characterization of microstructural
//         anisotropy in orthotropic materials using a second rank tensor, Journal of Materials
//         Science 19 (1984); M. Doube et al., BoneJ, Bone 47 (2010)
#pragma once

#include <array>
#include <optional>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

struct Anisotropy {
  /// 1 - smallest / largest eigenvalue of M: 0 for a structure alike in all directions, 1 where
  /// there are no intercepts in one.
  double degree = 0;
  std::array<double, 3> lengths_mm{};  ///< axes of the ellipsoid, the longest first; 0: no end
  std::array<Point3, 3> axes{};        ///< of index space in mm, for each length
};

/// Nothing where no line meets a surface. Uses the threads of the calling task arena.
/// region  lines are followed in it alone; null: in all of the volume
/// Throws  Error{cancelled}
/// Memory  that of two MaskAccessor
std::optional<Anisotropy> anisotropy(const MaskTree& mask, const MaskTree* region,
                                     const Point3& spacing_mm, Progress& progress);

}  // namespace octavo
