// Colours as people write them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "octavo/render/picture.h"

namespace octavo {

/// The colour of a name, or of "#rrggbb"; nothing for other text.
std::optional<Colour> find_colour(std::string_view text);

/// The names that find_colour knows, with commas between.
std::string colour_names();

}  // namespace octavo
