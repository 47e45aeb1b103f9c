// Ranges of values as people ask for them: in real units, or a tissue by name.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/ops/mask/mask_build.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// A range of real values, or of stored ones where that is said; both ends included. NaN and
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

/// Whole stored values whose real ones lie in the range; for float32 the quotients.
/// is_stored  the range is one of stored values
/// Throws Error{invalid_argument} when the volume's rescale slope is 0.
ValueWindow stored_window(const AskedRange& range, const VolumeDescription& volume,
                          bool is_stored);

}  // namespace octavo
