#include "octavo/render/label_color.h"

namespace octavo {

Color label_color(const LabelNames& names, std::int64_t label) {
  return names.color_of(label, label_color(label));
}

std::string label_text(const LabelNames& names, std::int64_t label) {
  const std::string& name = names.name_of(label);
  return name.empty() ? "label " + std::to_string(label) : name;
}

}  // namespace octavo
