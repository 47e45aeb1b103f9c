// Ranges of values on the command line and in JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "octavo/tasks/value_ranges.h"

namespace octavo::cli {

/// "LOW:HIGH", one end of which may be left out. Throws Error{invalid_argument} naming `option`.
AskedRange parse_range(const std::string& text, const std::string& option);

/// An end of a range; null where it is open.
nlohmann::ordered_json range_end_json(double value);

}  // namespace octavo::cli
