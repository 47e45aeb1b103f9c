// Stands in for label_walk_simd.cpp where the reading half is built without third-party code.
#include "octavo/codec/label_walk.h"

namespace octavo {

const LabelWalkFunctions& label_walk_functions() { return portable_label_walk_functions(); }

std::vector<LabelWalkFunctions> all_label_walk_functions() {
  return {portable_label_walk_functions()};
}

}  // namespace octavo
