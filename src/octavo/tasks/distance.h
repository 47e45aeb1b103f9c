// How far every voxel is from the surface of a mask.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/ops/distance/distance_field.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(DistanceTo) { return in_order<DistanceTo>("faces", "centers"); }

struct DistanceOptions {
  std::string input;  ///< a label map; every voxel but 0 is in the mask
  Output output;
  DistanceTo to = DistanceTo::faces;
  /// Distances beyond it become it, either sign; above 0.
  std::optional<double> max_mm;
  /// Whether voxels are int16 in steps, in place of float32.
  bool is_in_steps = false;
  /// Of int16 voxels; none: the smallest power of two that reaches the largest distance.
  std::optional<double> step_mm;
  /// How far a voxel may end up from its distance; none: not at all but by float32 or half a step.
  std::optional<double> within_mm;
};

struct DistanceResult {
  VolumeDescription volume;  ///< that was written
  double smallest_mm = 0;    ///< the deepest voxel inside, below 0
  double largest_mm = 0;     ///< the farthest outside
  DistanceHold hold = DistanceHold::memory;
  double max_error_mm = 0;   ///< that the file promises, half a step included
  std::uint64_t file_bytes = 0;
};

/// Writes the signed distance of each voxel's center from the surface of the mask, mm: below 0
/// inside, above 0 outside. Exact on every grid of perpendicular axes; what lies beyond the volume
/// is not known, and no distance ends there. Within a bound, octants that their neighbors on
/// coarser levels foretell so well take no bytes of their own, and every brick is decoded to prove
/// it: as in a distance map on an octree, whose cells are larger away from what bends it.
/// Throws  as require_computed, open_mask and build_file; Error{invalid_argument} for a mask that
///         is empty or fills the volume, for one of unknown spacing, a distance, step or bound that
///         is not above 0, a bound below half a step, a step too small for the largest distance or
///         longer than that; Error{limit_exceeded}
/// Source  S. Lavallée, R. Szeliski, Recovering the position and orientation of free-form objects
///         from image contours using 3D distance maps, IEEE Transactions on Pattern Analysis and
///         Machine Intelligence 17 (1995)
/// Memory  the mask and, of the limit, what plan_distance_field makes of half of what it leaves;
///         without a limit 1 GiB; beyond that a scratch file of 4 bytes a voxel beside the output
DistanceResult distance(const DistanceOptions& options, const TaskContext& context);

}  // namespace octavo
