#include <algorithm>
#include <cstring>
#include <type_traits>

#include "octavo/codec/grey_portable.h"
#include "octavo/codec/octant_transform.h"

namespace octavo::grey {

std::int64_t Stage::detail_count() const {
  if (cells == nullptr) return pairs.voxel_count();
  std::int64_t count = 0;
  for (std::int64_t z = 0; z < pairs.z; ++z) {
    for (std::int64_t y = 0; y < pairs.y; ++y) {
      const std::uint8_t* flags =
          cells->flags.data() +
          ((z >> cell_shift[2]) * cells->size.y + (y >> cell_shift[1])) * cells->size.x;
      for (std::int64_t x = 0; x < pairs.x; ++x) count += flags[x >> cell_shift[0]] == 0;
    }
  }
  return count;
}

const StageFunctions& portable_stage_functions() {
  static constexpr StageFunctions kFunctions = {
      portable::decode_stage<std::int16_t>, portable::encode_stage<std::int16_t>,
      portable::decode_stage<std::int32_t>, portable::encode_stage<std::int32_t>};
  return kFunctions;
}

}  // namespace octavo::grey
