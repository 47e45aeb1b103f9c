// Stands in for label_walk_simd.cpp where the reading half is built without third-party code.
#include "octavo/codec/label/label_walk.h"

namespace octavo {

const LabelWalkFunctions& label_walk_functions() { return portable_label_walk_functions(); }

std::optional<LabelWalkFunctions> label_walk_functions_of(std::string_view level) {
  if (level == "scalar") return portable_label_walk_functions();
  return std::nullopt;
}

}  // namespace octavo
