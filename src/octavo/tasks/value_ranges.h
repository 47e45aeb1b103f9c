// Ranges of values as people ask for them: in real units, or a tissue by name.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo {

/// A range of real values, or of stored ones where that is said; both ends included.
struct AskedRange {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

/// The tissues that have ranges, in HU.
std::vector<std::string> tissue_names();

/// The range of a tissue.
/// path    the file of `volume`
/// Throws  Error{invalid_argument} when the volume is not in HU, or no tissue has this name
AskedRange tissue_range(const std::string& name, const VolumeDescription& volume,
                        const std::string& path);

/// Whole stored values whose real ones lie in the range; for float32 the quotients.
/// is_stored  the range is one of stored values
/// Throws Error{invalid_argument} when the volume's rescale slope is 0.
ValueWindow stored_window(const AskedRange& range, const VolumeDescription& volume,
                          bool is_stored);

}  // namespace octavo
