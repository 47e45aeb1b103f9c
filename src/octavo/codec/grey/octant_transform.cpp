#include "octavo/codec/grey/octant_transform.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace octavo {

int rounding_term(const BrickShape& shape, int level, int axis, const AxisOrder& order) {
  const Size3 fine = weights_of(shape, level).each;
  const unsigned mask = shape.halving[static_cast<std::size_t>(level)];
  const auto coarse_of = [&](int a) { return fine[a] << (mask >> a & 1); };
  int turn = 0;
  bool is_before = true;
  for (const int other : order) {
    if (other == axis) is_before = false;
    else turn += coarse_of(other) > coarse_of(axis) ||
                 (is_before && coarse_of(other) == coarse_of(axis));
  }
  const int halvings = std::countr_zero(static_cast<std::uint64_t>(fine[axis]));
  return (turn + halvings + 1) & 1;
}

namespace {

/// The means of pairs of equal weights. Distances and widths that compilers know make vectors.
/// kStretch  from the first sample of a pair to that of the next; `step` to its partner
template <std::int64_t kStretch, class Sample>
void pair_means(const Sample* __restrict in, std::int64_t step, std::int64_t count, int rounding,
                Sample* __restrict out) {
  using Sum = std::conditional_t<sizeof(Sample) == 2, std::int32_t, std::int64_t>;
  for (std::int64_t x = 0; x < count; ++x) {
    const Sum a = in[kStretch * x];
    const Sum b = in[kStretch * x + step];
    out[x] = static_cast<Sample>(pair_mean<Sum>(a, b, rounding));
  }
}

}  // namespace

template <class Sample>
std::vector<Sample> means_along(const std::vector<Sample>& fine, const Size3& size, int axis,
                                int rounding, const PairWeights& last_pair) {
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
      const bool is_last = axis == 0 || (axis == 1 ? fine_y + 2 == size.y : fine_z + 2 == size.z);
      const bool has_weighted = is_last && !last_pair.are_equal();
      const std::int64_t alike = !has_weighted ? pairs : axis == 0 ? pairs - 1 : 0;
      if (axis == 0) pair_means<2>(in, 1, alike, rounding, out);
      else pair_means<1>(in, step, alike, rounding, out);
      for (std::int64_t x = alike; x < pairs; ++x) {
        const std::int64_t a = in[stretch * x];
        const std::int64_t b = in[stretch * x + step];
        out[x] = static_cast<Sample>(weighted_mean(a, b, last_pair, rounding));
      }
      for (std::int64_t x = pairs; x < coarse.x; ++x) out[x] = in[stretch * x];
      out += coarse.x;
    }
  }
  return means;
}

template <class Sample>
std::vector<Sample> coarser_level(std::vector<Sample> fine, const BrickShape& shape, int level,
                                  const AxisOrder& order) {
  const auto slot = static_cast<std::size_t>(level);
  const SampleWeights weights = weights_of(shape, level);
  Size3 size = shape.size[slot];
  for (const int axis : order) {
    if ((shape.halving[slot] >> axis & 1) == 0) continue;
    fine = means_along(fine, size, axis, rounding_term(shape, level, axis, order),
                       weights.last_pair(axis, size[axis]));
    size = halved(size, static_cast<HalvingMask>(1 << axis));
  }
  return fine;
}

template std::vector<std::int16_t> means_along(const std::vector<std::int16_t>&, const Size3&, int,
                                               int, const PairWeights&);
template std::vector<std::int32_t> means_along(const std::vector<std::int32_t>&, const Size3&, int,
                                               int, const PairWeights&);
template std::vector<std::int64_t> means_along(const std::vector<std::int64_t>&, const Size3&, int,
                                               int, const PairWeights&);
template std::vector<std::int16_t> coarser_level(std::vector<std::int16_t>, const BrickShape&,
                                                 int, const AxisOrder&);
template std::vector<std::int32_t> coarser_level(std::vector<std::int32_t>, const BrickShape&,
                                                 int, const AxisOrder&);
template std::vector<std::int64_t> coarser_level(std::vector<std::int64_t>, const BrickShape&,
                                                 int, const AxisOrder&);

}  // namespace octavo
