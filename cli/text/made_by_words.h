// What a computed volume was made by, in words.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace octavo::cli {

/// Whether `octavo condense` made the volume: its cubes hold means.
bool is_condensed(const nlohmann::ordered_json& metadata);

/// "components: connectivity 6, keep largest 1", "condensed with tolerance 20 HU: ..." from the
/// member "made_by"; "" where there is none.
std::string made_by_words(const nlohmann::ordered_json& metadata);

}  // namespace octavo::cli
