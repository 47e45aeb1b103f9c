// The rigid pose, or similarity, that lays points onto a surface, found through its distance map.
//
//     starts   the axes of both laid onto each other in 24 turns, each turned further in steps that
//              cover all rotations, and shifted along the axes; few points, a coarse map
//     middle   the best of them, more points
//     end      the best of those on the fine map, with all points
//
// Each is improved by the method of Levenberg and Marquardt on 6 or 7 numbers. A distance r counts
// as c^2 r^2 / (c^2 + r^2), so that points that have no counterpart (up to half of them) pull
// little; c shrinks from stage to stage.
//
// Source  S. Lavallée, R. Szeliski, Recovering the position and orientation of free-form objects
//         from image contours using 3D distance maps, IEEE Transactions on Pattern Analysis and
//         Machine Intelligence 17 (1995); S. Geman, D. McClure, Statistical methods for tomographic
//         image reconstruction, Bulletin of the ISI 52 (1987)
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/ops/align/distance_grid.h"
#include "octavo/ops/align/sight_lines.h"
#include "octavo/ops/grid/affine.h"

namespace octavo {

/// What points are laid onto.
struct PoseTarget {
  const DistanceGrid& coarse;
  const DistanceGrid& fine;
  Point3 middle{};                 ///< of its surface
  std::array<Point3, 3> axes{};    ///< of its surface: perpendicular unit vectors
  double radius_mm = 1;            ///< of its surface around the middle, root mean square
  double voxel_mm = 1;             ///< of the fine map
};

/// The ball in which lines of sight meet a target.
SightReach sight_reach(const PoseTarget& target);

struct FoundPose {
  Affine map;              ///< from the places of the points to those on the target
  double scale = 1;
  double overlap = 0;      ///< share of the points within two voxels of the surface
  double mean_mm = 0;      ///< distances of these
  double p95_mm = 0;
  double max_mm = 0;
  int iterations = 0;      ///< of the pose that was taken, in all stages
  /// Of the last system, lengths counted in radii: large where the surface does not hold the pose,
  /// above 90 for a ball or a rod, 4 to 25 for bodies of all kinds.
  double condition = 0;
};

/// The middle of points and the axes of their spread.
struct PointSpread {
  Point3 middle{};
  std::array<Point3, 3> axes{};
  double radius_mm = 0;
};
PointSpread spread_of(std::span<const Point3> points);

/// The best pose of points whose first parts are spread as all of them, as surface_points gives.
/// Uses the threads of the calling task arena; does not depend on them.
/// has_scale  a similarity in place of a rigid pose
/// Requires   points
/// Throws     Error{cancelled}
FoundPose find_pose(std::span<const Point3> points, const PoseTarget& target, bool has_scale,
                    Progress& progress);

/// The best pose of lines of sight, each of which touches the surface: the first of them from all
/// sides. Distances are the smallest of each line.
/// Requires  lines that hold their middle (SightMiddle)
/// Throws    Error{cancelled}
FoundPose find_pose(std::span<const SightLine> lines, const PoseTarget& target, bool has_scale,
                    Progress& progress);

/// A pose moved on by those of its points alone that have a counterpart.
/// found     its map, scale and iterations are what it begins with
/// points    all of them: what is said of distances is of these
/// facing    some of them; without any the pose stays, and is described
/// Requires  points
FoundPose settled_pose(const FoundPose& found, std::span<const Point3> points,
                       std::span<const Point3> facing, const PoseTarget& target, bool has_scale);

}  // namespace octavo
