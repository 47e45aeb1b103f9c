// Turns and scales as they are typed.
#pragma once

#include <string>
#include <vector>

#include "octavo/tasks/transform.h"

namespace octavo::cli {

/// "z:90", "x:-12.5", "1,1,0:30": an axis and degrees. Throws Error{invalid_argument}
AxisRotation parse_rotation(const std::string& text);

/// "x". Throws Error{invalid_argument}
int parse_mirror(const std::string& text);

/// "4" is 4 and finer, "1/4" is 4 and coarser; powers of two up to 64.
/// Throws Error{invalid_argument}
ScaleStep parse_scale(const std::string& text);

}  // namespace octavo::cli
