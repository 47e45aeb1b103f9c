// Colors as people write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "octavo/render/picture.h"

namespace octavo {

/// The color of a name, or of "#rrggbb"; nothing for other text.
std::optional<Color> find_color(std::string_view text);

/// The names that find_color knows, with commas between.
std::string color_names();

}  // namespace octavo
