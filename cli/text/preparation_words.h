// What was done to the slices of a source before they were folded, in words.
#pragma once

#include <string>

#include "octavo/core/metadata.h"

namespace octavo::cli {

/// The channel, time and segment that were taken of the source, "channel red of 4"; empty when it
/// had one of each.
std::string choice_words(const Metadata& metadata);

/// "gantry tilt of 18.5 degrees removed; 23 planes interpolated between slices"; empty when the
/// metadata names nothing. The metadata may come from any file.
std::string preparation_words(const Metadata& metadata);

/// "planes 128 to 259 are missing: their build was interrupted"; empty for a whole file.
std::string missing_words(const Metadata& metadata);

/// True when voxels were interpolated or moved, so that they are not those of the source.
bool was_resampled(const Metadata& metadata);

}  // namespace octavo::cli
