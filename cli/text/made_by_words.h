// What a computed volume was made by, in words.
#pragma once

#include <string>

#include "octavo/core/metadata.h"

namespace octavo::cli {

/// Whether `octavo condense` made the volume: its cubes hold means.
bool is_condensed(const Metadata& metadata);

/// "components: connectivity 6, keep largest 1", "condensed with tolerance 20 HU: ..." from the
/// member "made_by"; "" where there is none.
std::string made_by_words(const Metadata& metadata);

}  // namespace octavo::cli
