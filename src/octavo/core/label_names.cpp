#include "octavo/core/label_names.h"

#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/utf8.h"

namespace octavo {

void LabelNames::set(std::int64_t label, LabelName name) {
  if (names_.size() == kMaxLabels && !names_.contains(label)) {
    throw Error(ErrorKind::limit_exceeded,
                "names for more than " + std::to_string(kMaxLabels) + " labels");
  }
  name.name = std::string(cut_utf8(name.name, kMaxNameBytes));
  names_[label] = std::move(name);
}

const std::string& LabelNames::name_of(std::int64_t label) const {
  static const std::string kNone;
  const auto found = names_.find(label);
  return found == names_.end() ? kNone : found->second.name;
}

std::string LabelNames::text_of(std::int64_t label) const {
  const std::string& name = name_of(label);
  return name.empty() ? std::to_string(label) : name;
}

LabelColor LabelNames::color_of(std::int64_t label, const LabelColor& otherwise) const {
  const auto found = names_.find(label);
  return found == names_.end() ? otherwise : found->second.color.value_or(otherwise);
}

}  // namespace octavo
