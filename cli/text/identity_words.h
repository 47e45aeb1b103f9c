// What a file keeps of the identity of its source, in words.
#pragma once

#include <string>

#include "octavo/core/metadata.h"

namespace octavo::cli {

/// "kept", "dropped" or "none": what the metadata say of the identity of the source.
const char* identity_state(const Metadata& metadata);

/// One line for the screen; empty where the source gave nothing.
std::string identity_words(const Metadata& metadata);

/// What was kept with its values and what was dropped by name and count, a line each; empty where
/// the source gave nothing.
std::string identity_lines(const Metadata& metadata);

}  // namespace octavo::cli
