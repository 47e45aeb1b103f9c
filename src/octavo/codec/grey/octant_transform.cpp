#include "octavo/codec/grey/octant_transform.h"

#include <cstddef>
#include <utility>

namespace octavo {

template <class Sample>
std::vector<Sample> means_along(const std::vector<Sample>& fine, const Size3& size, int axis,
                                int rounding) {
  const Size3 coarse = halved(size, static_cast<HalvingMask>(1 << axis));
  const std::int64_t step = axis == 0 ? 1 : axis == 1 ? size.x : size.x * size.y;
  const std::int64_t stretch = axis == 0 ? 2 : 1;
  std::vector<Sample> means(static_cast<std::size_t>(coarse.voxel_count()));
  Sample* out = means.data();
  for (std::int64_t z = 0; z < coarse.z; ++z) {
    for (std::int64_t y = 0; y < coarse.y; ++y) {
      const std::int64_t fine_y = axis == 1 ? 2 * y : y;
      const std::int64_t fine_z = axis == 2 ? 2 * z : z;
      const Sample* in = fine.data() + (fine_z * size.y + fine_y) * size.x;
      const bool row_is_lone =
          (axis == 1 && fine_y + 1 == size.y) || (axis == 2 && fine_z + 1 == size.z);
      const std::int64_t pairs = row_is_lone ? 0 : axis == 0 ? size.x / 2 : size.x;
      for (std::int64_t x = 0; x < pairs; ++x) {
        const std::int64_t a = in[stretch * x];
        const std::int64_t b = in[stretch * x + step];
        out[x] = static_cast<Sample>(pair_mean(a, b, rounding));
      }
      for (std::int64_t x = pairs; x < coarse.x; ++x) out[x] = in[stretch * x];
      out += coarse.x;
    }
  }
  return means;
}

template <class Sample>
std::vector<Sample> coarser_level(std::vector<Sample> fine, Size3 size, HalvingMask mask, int level,
                                  const AxisOrder& order) {
  for (int place = 0; place < 3; ++place) {
    const int axis = order[static_cast<std::size_t>(place)];
    if ((mask >> axis & 1) == 0) continue;
    fine = means_along(fine, size, axis, rounding_term(place, level));
    size = halved(size, static_cast<HalvingMask>(1 << axis));
  }
  return fine;
}

template std::vector<std::int16_t> means_along(const std::vector<std::int16_t>&, const Size3&, int,
                                               int);
template std::vector<std::int32_t> means_along(const std::vector<std::int32_t>&, const Size3&, int,
                                               int);
template std::vector<std::int64_t> means_along(const std::vector<std::int64_t>&, const Size3&, int,
                                               int);
template std::vector<std::int16_t> coarser_level(std::vector<std::int16_t>, Size3, HalvingMask,
                                                 int, const AxisOrder&);
template std::vector<std::int32_t> coarser_level(std::vector<std::int32_t>, Size3, HalvingMask,
                                                 int, const AxisOrder&);
template std::vector<std::int64_t> coarser_level(std::vector<std::int64_t>, Size3, HalvingMask,
                                                 int, const AxisOrder&);

}  // namespace octavo
