// What a part of a measurement found, as lines of a part file.
#pragma once

#include <span>
#include <vector>

#include "octavo/core/json_text.h"
#include "octavo/ops/measure/measure.h"

namespace octavo {

/// A line for each region, and lines for its values.
std::vector<JsonObject> lines_of_regions(const PartOfRegions& regions);

/// The regions of such lines. Throws Error{corrupt}.
PartOfRegions regions_of_lines(std::span<const JsonObject> lines);

}  // namespace octavo
