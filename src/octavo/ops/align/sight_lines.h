// Lines of sight: what a contour in an X-ray picture says of a surface.
//
//     source o----------------(     )-----------> contour      the line touches the surface: the
//                              \___/                           smallest signed distance along it
//                             surface                          is 0
//
// A line that passes by has a smallest distance above 0, one that goes through below. Only outlines
// of shadows are such lines, not edges within them.
//
// Source  S. Lavallée, R. Szeliski, Recovering the position and orientation of free-form objects
//         from image contours using 3D distance maps, IEEE Transactions on Pattern Analysis and
//         Machine Intelligence 17 (1995)
#pragma once

#include <optional>
#include <span>

#include "octavo/ops/align/distance_grid.h"

namespace octavo {

/// A line through two places, as of the source of rays and of a point of a contour.
struct SightLine {
  Point3 from{};
  Point3 to{};
};

/// A ball that holds the surface that lines are laid onto.
struct SightReach {
  Point3 middle{};
  double radius_mm = 1;
};

/// The place on a line where the signed distance is smallest, within the ball or where the line
/// comes nearest to it.
struct NearestSight {
  Point3 place{};
  GridDistance distance;
  double along_mm = 0;  ///< from line.from on
};

/// expected_mm  where along the line it is likely to be, as of a pose that differs little: what is
///              found there lets more of the line be passed over
NearestSight nearest_sight(const DistanceGrid& grid, const SightLine& line, const SightReach& reach,
                           std::optional<double> expected_mm = std::nullopt);

/// The place that is nearest to all lines, by least squares, and how far they pass from it, root
/// mean square.
struct SightMiddle {
  Point3 middle{};
  double radius_mm = 0;
  /// How well lines hold the place along the direction in which they hold it worst: 0 where all run
  /// alike, 1/2 where half of them cross the others squarely.
  double hold = 0;
};
SightMiddle middle_of(std::span<const SightLine> lines);

}  // namespace octavo
