// One color per label.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/label_names.h"
#include "octavo/render/picture.h"

namespace octavo {

/// The color of a label, the same in every picture; 0 is black. Neighboring labels differ
/// strongly: hues step by the golden ratio of the circle, with three shades in turn.
Color label_color(std::int64_t label);

/// The color that a volume gives one of its labels; where it gives none, the one above.
Color label_color(const LabelNames& names, std::int64_t label);

/// What a picture calls a label: its name, or "label 7".
std::string label_text(const LabelNames& names, std::int64_t label);

}  // namespace octavo
