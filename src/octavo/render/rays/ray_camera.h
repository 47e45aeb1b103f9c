// From a view to the rays of its pixels.
#pragma once

#include "octavo/render/rays/ray_job.h"
#include "octavo/render/view.h"

namespace octavo {

struct RayCamera {
  View view;
  Box shown;  ///< the voxels that rays cross
  /// Angle from the top to the bottom of the picture, seen from an eye; 0: rays are parallel.
  double angle_degrees = 0;
  double step_mm = 1;  ///< from sample to sample
  double zoom = 1;     ///< that of the view: narrows the angle, and leaves the eye where it is
};

/// Sets where the rays of a frame run and what light falls on.
/// Throws Error{invalid_argument} when the angle is not between 0 and 170 degrees
void set_camera(RayFrame& frame, const RayCamera& camera);

/// How near a brick is in the order in which rays come to them: every ray comes to lower ones
/// first.
std::int64_t brick_nearness(const RayFrame& frame, const Index3& brick);

}  // namespace octavo
