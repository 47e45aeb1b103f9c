// Whether two surfaces laid onto each other are parts of the same one, or merely near.
//
// In a volume full of surfaces any shape comes to lie near one of them somewhere. A point agrees
// where the other surface is within a tolerance and faces the same way. Both ways are asked: do
// the points of the first agree with the second, and do those of the second that lie around them
// agree with the first. Of a foreign shape in a crowd the second share is small.
#pragma once

#include <span>

#include "octavo/ops/align/distance_grid.h"
#include "octavo/ops/grid/affine.h"

namespace octavo {

/// A surface by points on it and by the distances around it, both in its own world space.
struct PosedSurface {
  std::span<const Point3> points;
  const DistanceGrid& distances;
  double voxel_mm = 1;
};

/// Shares from 0 to 1.
struct PoseAgreement {
  double forward = 0;   ///< of the points of the first surface
  double backward = 0;  ///< of the points of the second that lie around those
};

/// Agreement within one voxel of the coarser surface, at most two of the second.
/// map  from the first surface to the second: a rigid map or a similarity
PoseAgreement agreement_of(const PosedSurface& first, const PosedSurface& second,
                           const Affine& map);

/// Points without sides, as of a mesh or a point set.
struct PosedPoints {
  std::span<const Point3> points;
  double spacing_mm = 1;  ///< from one to the next
};

/// The same within 1.5 voxels of the second surface, without a look at which way surfaces face; its
/// points agree where one of the first is no farther than that, or 1.5 times their spacing.
PoseAgreement agreement_of(const PosedPoints& first, const PosedSurface& second,
                           const Affine& map);

}  // namespace octavo
