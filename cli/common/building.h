// Builds a file from planes and says how it went: shared by `build` and `phantom`.
#pragma once

#include <string>

#include "common/context.h"
#include "octavo/build/plane_source.h"

namespace octavo::cli {

/// Builds `output` with progress and prints the result. Returns the exit code.
int build_and_report(PlaneSource& source, VolumeKind kind, const std::string& output,
                     const Context& context);

}  // namespace octavo::cli
