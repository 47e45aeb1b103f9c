// Colors from cold to hot for values from low to high, and plain colors for overlays without one.
#pragma once

#include <cstddef>
#include <vector>

#include "octavo/render/picture.h"

namespace octavo {

/// Blue, cyan, green, yellow, orange, red for a share of 0 .. 1 and what lies between.
Color scale_color(double share);

/// The whole scale in `count` steps, the lowest first.
std::vector<Color> scale_colors(std::size_t count);

/// The color of the overlay with this number; neighbors differ strongly.
Color overlay_color(std::size_t number);

}  // namespace octavo
