// One color per label.
#pragma once

#include <cstdint>

#include "octavo/core/label_names.h"

namespace octavo {

/// The color of a label, the same in every picture; 0 is black. Neighboring labels differ
/// strongly: hues step by the golden ratio of the circle, with three shades in turn.
LabelColor label_color(std::int64_t label);

}  // namespace octavo
