// Colors as people write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/render/picture.h"

namespace octavo {

/// The color of a name, or of "#rrggbb"; nothing for other text.
std::optional<Color> find_color(std::string_view text);

/// The names that find_color knows.
std::vector<std::string_view> named_colors();

/// The same, with commas between.
std::string color_names();

}  // namespace octavo
