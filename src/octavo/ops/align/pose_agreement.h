// Whether two surfaces laid onto each other are parts of the same one, or merely near.
//
// In a volume full of surfaces any shape comes to lie near one of them somewhere. A point agrees
// where the other surface is within a tolerance and faces the same way. Both ways are asked: do
// the points of the first agree with the second, and do those of the second that lie around them
// agree with the first. Of a foreign shape in a crowd the second share is small.
//
// Smooth bodies agree over much of their surface wherever they are laid onto each other, and a
// search makes the most of it. What tells them from parts of one body:
//
//     sharpness   distances of the same surface are as small as voxels are coarse, and gather at 0;
//                 those of surfaces that cross are spread over voxels
//     parting     cuts take away what lies behind a plane; what each of two different bodies has
//                 for itself lies all around
#pragma once

#include <span>
#include <vector>

#include "octavo/ops/align/distance_grid.h"
#include "octavo/ops/grid/affine.h"

namespace octavo {

/// A surface by points on it and by the distances around it, both in its own world space.
struct PosedSurface {
  std::span<const Point3> points;
  const DistanceGrid& distances;
  double voxel_mm = 1;
  /// Mean edge of its voxels. Where they are longer one way than others, most of its places are
  /// off by more than a share of voxel_mm.
  double edge_mm = 1;
};

/// Shares from 0 to 1.
struct PoseAgreement {
  double forward = 0;   ///< of the points of the first surface
  double backward = 0;  ///< of the points of the second that lie around those
  /// Of the points of the first that the second faces the same way within four edges of voxels,
  /// those for which it does so within half an edge, of the coarser of both. 0 where none is near.
  double sharpness = 0;
  /// How well one plane parts what the first alone has outside of the second from what the second
  /// alone has outside of the first: the share of both that is on its side, each counted as half.
  /// 1 where one of them has less than a twentieth of its points there.
  double parting = 1;
  bool has_both_alone = false;  ///< each has a twentieth or more there: both were cut, or differ
};

/// Agreement within one voxel of the coarser surface, at most two of the second.
/// map  from the first surface to the second: a rigid map or a similarity
PoseAgreement agreement_of(const PosedSurface& first, const PosedSurface& second,
                           const Affine& map);

/// The points of the first that the second faces the same way within four edges: not those of a
/// cut, which lie near other faces of the second and pull at a pose.
std::vector<Point3> facing_points(const PosedSurface& first, const PosedSurface& second,
                                  const Affine& map);

/// Points without sides, as of a mesh or a point set.
struct PosedPoints {
  std::span<const Point3> points;
  double spacing_mm = 1;  ///< from one to the next
};

/// The same within 1.5 voxels of the second surface, without a look at which way surfaces face; its
/// points agree where one of the first is no farther than that, or 1.5 times their spacing.
/// Sharpness counts in edges of the second; parting, for which sides are needed, stays 1.
PoseAgreement agreement_of(const PosedPoints& first, const PosedSurface& second,
                           const Affine& map);

/// Sharpness of distances of points for which nothing is known of sides.
double sharpness_of(std::span<const double> distances_mm, double edge_mm);

}  // namespace octavo
