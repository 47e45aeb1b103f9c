// What a build has made, in words and JSON.
#pragma once

#include <string>

#include "common/context.h"
#include "octavo/tasks/build_planes.h"

namespace octavo::cli {

/// Prints the file that was built as the context asks for.
void print_built(const BuiltVolume& built, const std::string& output, const Context& context);

}  // namespace octavo::cli
