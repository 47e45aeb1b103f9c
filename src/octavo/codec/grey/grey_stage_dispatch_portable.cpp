// Stands in for grey_stage_simd.cpp where the reading half is built without third-party code.
#include "octavo/codec/grey/grey_stage.h"

namespace octavo::grey {

const StageFunctions& stage_functions() { return portable_stage_functions(); }

std::optional<StageFunctions> stage_functions_of(std::string_view level) {
  if (level == "scalar") return portable_stage_functions();
  return std::nullopt;
}

}  // namespace octavo::grey
