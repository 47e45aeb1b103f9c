#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "octavo/codec/grey/edge_candidates.h"
#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/octant_transform.h"

namespace octavo::grey {

namespace {

/// The weighted sum of the taps around a sample; 16-bit samples sum modulo 2^32.
template <int kAxis, class Sample>
Wide<Sample> weighted_sum(const Sample* at, const std::int16_t* weights) {
  using Sum = std::make_unsigned_t<Wide<Sample>>;
  Sum sum = 0;
  for (int r = 0; r < TapRows<Sample>::kCount[kAxis]; ++r) {
    const Sample* taps = at + TapRows<Sample>::kOffsets[kAxis][r];
    for (int i = 0; i < 8; ++i) {
      sum += static_cast<Sum>(Wide<Sample>{taps[i]} * weights[8 * r + i]);
    }
  }
  return static_cast<Wide<Sample>>(sum);
}

/// Predicted magnitude (Q8) to context: its half-octave, in a second bank where the range limits
/// it.
int context_of(std::int32_t predicted, std::int32_t limit) {
  const bool is_limited = predicted > 128 * (limit - 1);
  predicted = std::min(predicted, limit << 8);
  // The exponent and first mantissa bit of a float count half-octaves; 8 = 2^3 is number 0.
  const auto value = static_cast<float>(predicted + 8);
  std::int32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  const std::int32_t half_octave = std::min((bits >> 22) - 260, kMagnitudes - 1);
  return half_octave + (is_limited ? kMagnitudes : 0);
}

/// The multiple of a step closest to a residual, with a bias towards 0: small ones cost less.
template <class Int>
Int quantized(Int residual, std::int32_t step) {
  using Real = std::conditional_t<sizeof(Int) == 4, float, double>;
  const Int magnitude = residual < 0 ? -residual : residual;
  const auto count = static_cast<Int>(static_cast<Real>(magnitude + rounding_bias(step)) *
                                      (Real{1} / static_cast<Real>(step)));
  return residual < 0 ? -count * step : count * step;
}

template <int kAxis, bool kIsEncoding, class Sample>
void reconstruct_row_along(const Parameters& p, const Stage& stage, Workspace<Sample>& work,
                           std::int64_t y, std::int64_t z) {
  using Int = Wide<Sample>;
  constexpr std::int64_t kStep = pair_step<Sample>(kAxis);
  const bool is_from_means = p.predictor == Predictor::means;
  const auto& weights = p.weights[stage.group][kAxis];
  const auto& mean_weights = p.mean_weights[stage.group][kAxis];
  const auto& behind_weights = p.behind_weights[stage.group][kAxis];
  const std::int32_t far_share = p.far_shares[stage.group][kAxis];
  Int* const excesses = work.excesses.row(y, z);
  if (is_from_means && z == 0) std::fill_n(excesses, stage.pairs.x, Int{0});
  const std::uint8_t* const activities = work.activities.row(y, z);
  const Limit<Sample>* const limits = work.limits.row(y, z);
  Int* const residuals = work.residuals.row(y, z);
  const Int* const edges = edge_details(stage, work, y, z);
  Sample* const first = first_of_row(work.fine, kAxis, y, z);
  const Sample* const means = work.means.row(y, z);
  const std::int64_t weighted = stage.first_weighted(y, z);
  for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
    Sample* const at = first + pair_stretch(kAxis) * x;
    const Int limit = limits[x];
    const std::uint8_t activity = activities[x];
    // Predict, within what the value range allows
    const Int likely = std::clamp<Int>(
        is_from_means ? predict_from_means(means + x, kStep, mean_weights[activity], far_share)
                      : rounded_weights(weighted_sum<kAxis>(at, weights[activity])),
        -limit, limit);
    Int expected = likely;
    if (is_from_means) {
      expected += (excesses[x] * behind_weights[activity] + kHalfShare) >> kShareBits;
      expected = std::clamp<Int>(expected, -limit, limit);
    }
    // An edge has no room: its detail is known. Details are counted from there.
    const Int known = edges != nullptr ? edges[x] : 0;
    // Detail to residual, or residual to detail
    Int detail;
    if (stage.gaps != nullptr) {
      const ValueGaps::Details& possible = stage.gaps->of(means[x]);
      const int nearest = possible.nearest(known + expected);
      if constexpr (kIsEncoding) {
        detail = residuals[x];
        residuals[x] = folded(possible.nearest(detail), nearest, possible.last);
      } else {
        detail = possible.detail(unfolded<Int>(residuals[x], nearest, possible.last));
      }
      detail = std::clamp<Int>(detail - known, -limit, limit);
    } else if constexpr (kIsEncoding) {
      // The means of quantized details leave other room than the true ones.
      detail = std::clamp<Int>(residuals[x] - known, -limit, limit);
      if (stage.step > 1) {
        residuals[x] = quantized<Int>(detail - expected, stage.step);
        detail = std::clamp<Int>(expected + residuals[x], -limit, limit);
      } else {
        residuals[x] = residual_of(detail, expected, limit);
      }
    } else {
      detail = decoded_detail<Int>(residuals[x], expected, limit, stage.step);
    }
    if (is_from_means) excesses[x] = detail - likely;
    detail += known;
    // Mean and detail to the two samples
    if (x < weighted) {
      const Pair<Int> pair = pair_of<Int>(means[x], detail, stage.rounding);
      at[0] = static_cast<Sample>(pair.a);
      at[kStep] = static_cast<Sample>(pair.b);
    } else {
      const Pair<Sample> pair = weighted_pair<Sample>(stage, means[x], detail);
      at[0] = pair.a;
      at[kStep] = pair.b;
    }
  }
}

}  // namespace

template <class Sample>
void PortableKernel<Sample>::some_features(const Parameters& p, const Stage& stage,
                                           Workspace<Sample>& work, const Box& pairs) {
  const std::int64_t along = pair_step<Sample>(stage.axis);
  const std::int64_t across1 = pair_step<Sample>(stage.axis == 0 ? 1 : 0);
  const std::int64_t across2 = pair_step<Sample>(stage.axis == 2 ? 1 : 2);
  const Sample* m = work.means.row(pairs.lo.y, pairs.lo.z);
  std::uint8_t* const activities = work.activities.row(pairs.lo.y, pairs.lo.z);
  Limit<Sample>* const limits = work.limits.row(pairs.lo.y, pairs.lo.z);
  const int shift = stage.shift;
  const auto min = static_cast<Int>(stage.min);
  const auto max = static_cast<Int>(stage.max);
  const Int threshold = p.activity_threshold;
  const auto step = [shift](Int d) { return (d < 0 ? -d : d) >> shift; };
  const auto feature = [](Int sum) {
    return static_cast<std::uint16_t>(std::min<Int>(sum, kMaxFeature));
  };
  for (std::int64_t x = pairs.lo.x; x < pairs.hi.x; ++x) {
    const Int c = m[x];
    const Int before = m[x - along] - c;
    const Int after = m[x + along] - c;
    const Int e0 = step(before) + step(after);
    const Int e2 = step(m[x - across1] - c) + step(m[x + across1] - c) +
                   step(m[x - across2] - c) + step(m[x + across2] - c);
    const Int g = e0 + e2;
    activities[x] = static_cast<std::uint8_t>((g > 0) + (g >= threshold / 4) + (g >= threshold) +
                                              (g >= 4 * threshold));
    limits[x] = static_cast<Limit<Sample>>(
        std::min<Int>(2 * (c - min) + stage.odd_low, 2 * (max - c) + stage.odd_high));
    work.row.limit[x] = static_cast<std::uint16_t>(limits[x] >> shift);
    work.row.gradient_along[x] = feature(e0);
    work.row.curvature_along[x] = feature(step(before + after));
    work.row.gradient_across[x] = feature(e2);
  }
}

template <class Sample>
void PortableKernel<Sample>::row_contexts(const Parameters& p, const Stage& stage,
                                          const MagnitudeRows& near, const RowBuffers& row,
                                          std::uint16_t* contexts) {
  const std::int32_t* w = p.context_weights[stage.group][stage.axis];
  for (std::int64_t x = 0; x < stage.pairs.x; ++x) {
    const std::int32_t predicted =
        w[0] * row.gradient_along[x] + w[1] * row.curvature_along[x] +
        w[2] * row.gradient_across[x] + w[3] * near.sibling[0][x] + w[4] * near.sibling[1][x] +
        w[5] + w[6] * near.up[x + 2] + w[7] * near.up[x - 2] + w[8] * near.up[x] +
        w[9] * near.up[x - 1] + w[10] * near.up[x + 1] + w[11] * near.back[x] +
        w[12] * near.back[x - 1] + w[13] * near.back[x + 1] + w[14] * near.back_up[x] +
        w[15] * near.back_down[x];
    const int context = context_of(predicted, row.limit[x]);
    contexts[x] = static_cast<std::uint16_t>(context | plain_bits(context, stage.step_bits) << 8);
  }
}

template <class Sample>
template <bool kIsEncoding>
void PortableKernel<Sample>::reconstruct_row(const Parameters& p, const Stage& stage,
                                             Workspace<Sample>& work, std::int64_t y,
                                             std::int64_t z) {
  if (stage.axis == 0) reconstruct_row_along<0, kIsEncoding>(p, stage, work, y, z);
  else if (stage.axis == 1) reconstruct_row_along<1, kIsEncoding>(p, stage, work, y, z);
  else reconstruct_row_along<2, kIsEncoding>(p, stage, work, y, z);
}

template <class Sample>
template <bool kIsEncoding>
void PortableKernel<Sample>::reconstruct(const Parameters& p, const Stage& stage,
                                         Workspace<Sample>& work) {
  for (std::int64_t z = 0; z < stage.pairs.z; ++z) {
    for (std::int64_t y = 0; y < stage.pairs.y; ++y)
      reconstruct_row<kIsEncoding>(p, stage, work, y, z);
  }
}

template struct PortableKernel<std::int16_t>;
template struct PortableKernel<std::int32_t>;

namespace {

/// Every bit of the first half of a mask twice.
RowMask doubled(RowMask mask) {
  constexpr RowMask kEvery[] = {0x0000ffff0000ffff, 0x00ff00ff00ff00ff, 0x0f0f0f0f0f0f0f0f,
                                0x3333333333333333, 0x5555555555555555};
  mask &= first_pairs(32);
  int distance = 16;
  for (const RowMask every : kEvery) {
    mask = (mask | mask << distance) & every;
    distance /= 2;
  }
  return mask | mask << 1;
}

/// The pairs of a row that lie in no uniform cell.
RowMask pairs_beside_cells(const Stage& stage, std::int64_t y, std::int64_t z) {
  const RowMask all = first_pairs(stage.pairs.x);
  if (stage.cells == nullptr) return all;
  const Size3& size = stage.cells->size;
  const std::uint8_t* flags =
      stage.cells->flags.data() +
      ((z >> stage.cell_shift[2]) * size.y + (y >> stage.cell_shift[1])) * size.x;
  RowMask flagged = 0;
  std::int64_t x = 0;
  for (; x + 8 <= size.x; x += 8) flagged |= mask_of_bytes(flags + x) << x;
  for (; x < size.x; ++x) flagged |= RowMask{flags[x]} << x;
  for (int i = 0; i < stage.cell_shift[0]; ++i) flagged = doubled(flagged);
  return ~flagged & all;
}

/// Calls f(rows) for the rows of pairs that lie in the same cells: y and z of a box.
template <class F>
void for_each_row_of_cells(const Stage& stage, F&& f) {
  const auto side = [&](int axis) { return std::int64_t{1} << stage.cell_shift[axis]; };
  for (std::int64_t z = 0; z < stage.pairs.z; z += side(2)) {
    for (std::int64_t y = 0; y < stage.pairs.y; y += side(1)) {
      f(Box{{0, y, z},
            {stage.pairs.x, std::min(y + side(1), stage.pairs.y),
             std::min(z + side(2), stage.pairs.z)}});
    }
  }
}

}  // namespace

void find_open_pairs(const Stage& stage, PairMasks& open) {
  for_each_row_of_cells(stage, [&](const Box& rows) {
    const RowMask pairs = pairs_beside_cells(stage, rows.lo.y, rows.lo.z);
    for (std::int64_t z = rows.lo.z; z < rows.hi.z; ++z) {
      for (std::int64_t y = rows.lo.y; y < rows.hi.y; ++y) open.row(y, z) = pairs;
    }
  });
}

std::int64_t Stage::detail_count() const {
  if (cells == nullptr) return pairs.voxel_count();
  std::int64_t count = 0;
  for_each_row_of_cells(*this, [&](const Box& rows) {
    const std::int64_t alike = (rows.hi.y - rows.lo.y) * (rows.hi.z - rows.lo.z);
    count += alike * std::popcount(pairs_beside_cells(*this, rows.lo.y, rows.lo.z));
  });
  return count;
}

const StageFunctions& portable_stage_functions() {
  static constexpr StageFunctions kFunctions = {
      passes_of<std::int16_t, PortableKernel<std::int16_t>, PortableEdges<std::int16_t>>(),
      passes_of<std::int32_t, PortableKernel<std::int32_t>, PortableEdges<std::int32_t>>(),
      push_tokens};
  return kFunctions;
}

}  // namespace octavo::grey
