// Where golden files and tools of the project lie.
#pragma once

#include <string>

namespace octavo::testing {

/// The root of the source tree, without a slash at its end.
std::string source_folder();

}  // namespace octavo::testing
