// Builds a file from planes and says how it went: shared by `build` and `phantom`.
#pragma once

#include <string>

#include "common/context.h"
#include "octavo/build/builder.h"

namespace octavo::cli {

/// Builds `output` with progress and prints the result. Returns the exit code.
/// options  what to build; overwrite, threads and memory are those of `context`
int build_and_report(PlaneSource& source, BuildOptions options, const std::string& output,
                     const Context& context);

}  // namespace octavo::cli
