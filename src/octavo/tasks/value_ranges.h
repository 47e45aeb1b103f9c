// Ranges of values as people ask for them: in real units, or a tissue by name.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/ops/mask/mask_build.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// A range of real values, or of stored ones where that is said; both ends included, as numbers are
/// read: an end of float32 voxels is the nearest float32, and voxels behind a slope or an intercept
/// that is no whole number reach an end that they miss by a rounding of float32 alone. NaN and
/// infinities lie in none, not in open ones either.
struct AskedRange {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

/// The tissues that have ranges, in HU.
std::vector<std::string> tissue_names();

/// The range of a tissue, in HU. Throws Error{invalid_argument} when no tissue has this name.
AskedRange tissue_range(const std::string& name);

/// Proves that tissues may be asked of a volume: that each is one, and as require_hu.
/// path  the file of `volume`
void check_tissues(const std::vector<std::string>& names, const VolumeDescription& volume,
                   const std::string& path, const TaskContext& context);

/// The stored values whose real ones lie in the range, for all that compares voxels with real
/// values that were asked for.
/// is_stored  the range is one of stored values
/// Throws Error{invalid_argument} when the volume's rescale slope is 0.
ValueWindow stored_window(const AskedRange& range, const VolumeDescription& volume,
                          bool is_stored);

}  // namespace octavo
