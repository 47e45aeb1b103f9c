#include "octavo/core/given_label.h"

#include <limits>

#include "octavo/core/label_names.h"
#include "octavo/core/utf8.h"

namespace octavo {

bool is_label(std::int64_t number) noexcept {
  return number >= std::numeric_limits<std::int32_t>::min() &&
         number <= std::numeric_limits<std::uint32_t>::max();
}

std::string label_name_fault(std::string_view name) {
  if (name.find_first_not_of(" \t") == std::string_view::npos) return "is empty";
  if (name.size() > LabelNames::kMaxNameBytes) {
    return "is longer than " + std::to_string(LabelNames::kMaxNameBytes) + " bytes";
  }
  return has_control(name, "\t") || turns_text(name) ? "holds a control character" : "";
}

}  // namespace octavo
