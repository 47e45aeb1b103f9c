// What a volume calls its labels in pictures, and their colors.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/label_color.h"
#include "octavo/core/label_names.h"
#include "octavo/render/picture.h"

namespace octavo {

/// The color that a volume gives one of its labels; where it gives none, that of label_color.
Color label_color(const LabelNames& names, std::int64_t label);

/// What a picture calls a label: its name, or "label 7".
std::string label_text(const LabelNames& names, std::int64_t label);

}  // namespace octavo
