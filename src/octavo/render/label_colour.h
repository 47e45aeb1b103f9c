// One colour per label.
#pragma once

#include <cstdint>

#include "octavo/render/picture.h"

namespace octavo {

/// The colour of a label, the same in every picture; 0 is black. Neighbouring labels differ
/// strongly: hues step by the golden ratio of the circle, with three shades in turn.
Colour label_colour(std::int64_t label);

}  // namespace octavo
