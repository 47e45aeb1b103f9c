// The ellipsoid factor: whether a structure is made of plates (-1), rods (1), or neither (0).
//
// Around centers of fitting balls an ellipsoid grows until the surface holds it: the shortest axis
// towards the nearest place of the surface, the next across it, the last across both. Its center,
// axes and lengths are then changed as long as it becomes larger (ellipsoid_search.h).
//
//     a <= b <= c      a / b - b / c      plate: a << b = c      rod: a = b << c
//
// Each center takes the factor of the largest ellipsoid that holds it, and stands for the volume of
// its own over how many hold it: the mean is that of the volume that all together hold.
//
// The surface is where rays from the center leave the class; the border of the volume counts as
// surface.
//
// Source  M. Doube, The ellipsoid factor for quantification of rods, plates, and intermediate forms
//         in 3D geometries, Frontiers in Endocrinology 6 (2015)
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "octavo/ops/morphometry/fitting_balls.h"

namespace octavo {

struct EllipsoidFactors {
  std::uint64_t ellipsoids = 0;
  double mean = 0;       ///< by the volume that ellipsoids hold together
  double deviation = 0;
  /// Volume in twenty steps from -1 to 1, as shares.
  std::array<double, 20> shares{};
};

/// How many ellipsoids grow around balls.
std::int64_t ellipsoid_count(const std::vector<FittingBall>& balls);

/// Of up to 1000 balls, spread evenly over their sizes; nothing without balls.
/// progress  advances by ellipsoid_count(balls)
/// Uses the threads of the calling task arena; does not depend on them.
/// Throws  Error{cancelled}
/// Memory  that of a MaskAccessor
std::optional<EllipsoidFactors> ellipsoid_factors(const ThicknessClass& asked,
                                                  const Point3& spacing_mm,
                                                  const std::vector<FittingBall>& balls,
                                                  Progress& progress);

}  // namespace octavo
