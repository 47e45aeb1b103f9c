// How far every voxel is from the surface of a mask.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/volume.h"
#include "octavo/ops/distance/distance_field.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

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
};

struct DistanceResult {
  VolumeDescription volume;  ///< that was written
  double smallest_mm = 0;    ///< the deepest voxel inside, below 0
  double largest_mm = 0;     ///< the farthest outside
  DistanceHold hold = DistanceHold::memory;
  std::uint64_t file_bytes = 0;
};

/// Writes the signed distance of each voxel's center from the surface of the mask, mm: below 0
/// inside, above 0 outside. Exact on every grid of perpendicular axes; what lies beyond the volume
/// is not known, and no distance ends there.
/// Throws  as require_computed, open_mask and build_file; Error{invalid_argument} for a mask that
///         is empty or fills the volume, for one of unknown spacing, a distance or step that is not
///         above 0 or a step too small for the largest distance; Error{limit_exceeded}
/// Memory  the mask and, of the limit, what plan_distance_field makes of half of what it leaves;
///         without a limit 1 GiB; beyond that a scratch file of 4 bytes a voxel beside the output
DistanceResult distance(const DistanceOptions& options, const TaskContext& context);

}  // namespace octavo
