// Ranges of values as people ask for them: LOW:HIGH in real units, or a tissue by name.
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo::cli {

/// A range of real values, or of stored ones with --stored; both ends included.
struct AskedRange {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

/// "LOW:HIGH", one end of which may be left out. Throws Error{invalid_argument} naming `option`.
AskedRange parse_range(const std::string& text, const char* option);

/// The names that --tissue knows.
std::vector<std::string> tissue_names();

/// The range of a tissue. Requires one of tissue_names().
/// path    the file of `volume`
/// Throws  Error{invalid_argument} when the volume is not in HU
AskedRange tissue_range(const std::string& name, const VolumeDescription& volume,
                        const std::string& path);

/// Whole stored values whose real ones lie in the range; for float32 the quotients.
/// is_stored  the range is one of stored values
/// Throws Error{invalid_argument} when the volume's rescale slope is 0.
ValueWindow stored_window(const AskedRange& range, const VolumeDescription& volume,
                          bool is_stored);

/// An end of a range; null where it is open.
nlohmann::ordered_json range_end_json(double value);

}  // namespace octavo::cli
