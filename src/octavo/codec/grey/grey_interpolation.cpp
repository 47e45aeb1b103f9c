#include "octavo/codec/grey/grey_interpolation.h"

#include <algorithm>

#include "octavo/codec/grey/grey_portable.h"

namespace octavo::grey {

namespace {

/// What the means around a place predict; `along` is the distance of neighbors.
template <class Sample>
Wide<Sample> predicted_detail(const Sample* mean, std::int64_t along) {
  using Int = Wide<Sample>;
  const Int near = Int{mean[-along]} - mean[along];
  const Int far = Int{mean[-2 * along]} - mean[2 * along];
  return (14 * near - 3 * far + 16) >> 5;
}

/// The samples of one pair.
template <class Sample>
Pair<Sample> interpolated_pair(const Stage& stage, Wide<Sample> mean, Wide<Sample> expected,
                               bool is_weighted) {
  using Int = Wide<Sample>;
  const Int room = std::min<Int>(2 * (mean - static_cast<Int>(stage.min)) + stage.odd_low,
                                 2 * (static_cast<Int>(stage.max) - mean) + stage.odd_high);
  const Int limit = is_weighted ? static_cast<Int>(stage.max - stage.min) : room;
  const Int detail = std::clamp<Int>(expected, -limit, limit);
  if (is_weighted) return weighted_pair<Sample>(stage, mean, detail);
  const Pair<Int> pair = pair_of<Int>(mean, detail, stage.rounding);
  return {static_cast<Sample>(pair.a), static_cast<Sample>(pair.b)};
}

/// The means of a split to its samples.
template <class Sample>
void interpolate_split(const Stage& stage, Workspace<Sample>& work) {
  const std::int64_t along = pair_step<Sample>(stage.axis);
  const std::int64_t stretch = pair_stretch(stage.axis);
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
      const Sample* const means = work.means.row(y, z);
      Sample* const first = first_of_row(work.fine, stage.axis, y, z);
      const std::int64_t weighted = stage.first_weighted(y, z);
      for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
        const Pair<Sample> pair = interpolated_pair<Sample>(
            stage, means[x], predicted_detail(means + x, along), x >= weighted);
        Sample* const at = first + stretch * x;
        at[0] = pair.a;
        at[along] = pair.b;
      }
    }
  }
}

/// Splits that are written without being read.
const Parameters& from_means() {
  static const Parameters parameters = [] {
    Parameters p;
    p.predictor = Predictor::means;
    return p;
  }();
  return parameters;
}

}  // namespace

int detailed_level(const Parameters& p, const BrickShape& shape) {
  return shape.first_level == 0 ? std::min(p.detail_level, shape.level_count - 1) : 0;
}

BrickShape shape_from(const BrickShape& shape, int level) {
  BrickShape rest = shape;
  rest.first_level += level;
  rest.level_count -= level;
  rest.weights = weights_of(shape, level);
  std::copy(shape.size.begin() + level, shape.size.end(), rest.size.begin());
  std::copy(shape.halving.begin() + level, shape.halving.end(), rest.halving.begin());
  return rest;
}

template <class Sample>
void interpolate_levels(Workspace<Sample>& work, const BrickShape& shape, const SampleScale& scale,
                        int from, int to) {
  work.means.fill_margins();
  for (int level = from - 1; level >= to; --level) {
    run_level(work, Part{shape, {}, {}, kAllFaces}, scale, from_means(), level, {},
              Margins::all,
              [&](const Stage& stage, const Split&) { interpolate_split(stage, work); });
  }
}

template void interpolate_levels(Workspace<std::int16_t>&, const BrickShape&, const SampleScale&,
                                 int, int);
template void interpolate_levels(Workspace<std::int32_t>&, const BrickShape&, const SampleScale&,
                                 int, int);

}  // namespace octavo::grey
