// The row pass of a split, vectorized: features, contexts, samples from means.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_ROWS_INL_H
#undef OCTAVO_CODEC_GREY_ROWS_INL_H
#else
#define OCTAVO_CODEC_GREY_ROWS_INL_H
#endif

#include <hwy/highway.h>

#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/grey_residuals-inl.h"

// Places within a row are small numbers.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

/// 16 lanes at most, so that a row's padding suffices; their sums are in 32-bit lanes, half as
/// many.
constexpr hn::CappedTag<std::uint16_t, 16> kHalves{};
constexpr hn::RebindToSigned<decltype(kHalves)> kSignedHalves{};
constexpr hn::RepartitionToWide<decltype(kHalves)> kSums{};
constexpr hn::RebindToSigned<decltype(kSums)> kSignedSums{};
using Halves = hn::Vec<decltype(kHalves)>;
using SignedHalves = hn::Vec<decltype(kSignedHalves)>;
using SignedSums = hn::Vec<decltype(kSignedSums)>;

/// |a - b|, exact for any two samples.
HWY_INLINE Halves distance(SignedHalves a, SignedHalves b) {
  return hn::Sub(hn::BitCast(kHalves, hn::Max(a, b)), hn::BitCast(kHalves, hn::Min(a, b)));
}

/// Whether a >= b, as 1 or 0.
HWY_INLINE Halves is_at_least(Halves a, Halves b) {
  return hn::ShiftRight<15>(hn::VecFromMask(kHalves, hn::Eq(hn::Max(a, b), a)));
}

/// For each lane the bit of its pair, in the 16 pairs from that of the first lane on.
alignas(64) inline constexpr std::uint16_t kLaneBits[] = {
    1 << 0, 1 << 1, 1 << 2,  1 << 3,  1 << 4,  1 << 5,  1 << 6,  1 << 7,
    1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15};

/// The lanes whose pairs are among some pairs of a row; lane 0 is pair x.
HWY_INLINE hn::Mask<decltype(kHalves)> lanes_of(RowMask pairs, int x) {
  return hn::TestBit(hn::Set(kHalves, static_cast<std::uint16_t>(pairs >> x)),
                     hn::Load(kHalves, kLaneBits));
}

/// The bits of a mask, that of the first lane lowest.
HWY_INLINE RowMask bits_of(hn::Mask<decltype(kHalves)> lanes) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(kHalves, lanes, bits);
  return static_cast<RowMask>(bits[0] | bits[1] << 8);
}

/// close_pairs; what is behind the row stays as it is.
inline void close_limits(RowMask coded, std::int64_t count, std::uint16_t* limits) {
  const RowMask all = first_pairs(count);
  if (coded == all) return;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kHalves));
  for (int x = 0; x < count; x += kLanes) {
    const auto stays = lanes_of(coded | ~all, x);
    hn::StoreU(hn::IfThenElseZero(stays, hn::LoadU(kHalves, limits + x)), kHalves, limits + x);
  }
}

inline void features_of_row(const Parameters& p, const Stage& stage,
                            Workspace<std::int16_t>& work, std::int64_t y, std::int64_t z) {
  const std::int64_t along = pair_step<std::int16_t>(stage.axis);
  const std::int64_t across1 = pair_step<std::int16_t>(stage.axis == 0 ? 1 : 0);
  const std::int64_t across2 = pair_step<std::int16_t>(stage.axis == 2 ? 1 : 2);
  const std::int16_t* m = work.means.row(y, z);
  std::uint8_t* const activities = work.activities.row(y, z);
  std::uint16_t* const limits = work.limits.row(y, z);
  RowBuffers& row = work.row;
  const auto set = [](std::int64_t value) {
    return hn::Set(kHalves, static_cast<std::uint16_t>(value));
  };
  const Halves quarter = set(p.activity_threshold / 4);
  const Halves threshold = set(p.activity_threshold);
  const Halves fourfold = set(4 * p.activity_threshold);
  const Halves flip = set(0x8000);
  const Halves min = hn::Xor(set(stage.min), flip);
  const Halves max = hn::Xor(set(stage.max), flip);
  const Halves most = set(kMaxFeature);
  const Halves one = set(1);
  const Halves odd_low = set(stage.odd_low);
  const Halves odd_high = set(stage.odd_high);
  const auto sample = [&](std::int64_t at) { return hn::LoadU(kSignedHalves, m + at); };
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kHalves));
  for (int x = 0; x < stage.pairs.x; x += kLanes) {
    // Gradients and curvature of the means around
    const SignedHalves c = sample(x);
    const SignedHalves before = sample(x - along);
    const SignedHalves after = sample(x + along);
    const Halves down = distance(before, c);
    const Halves up = distance(after, c);
    const Halves e0 = hn::SaturatedAdd(down, up);
    // Steps of one sign add up in the curvature, others cancel.
    const auto is_one_sign = hn::Eq(hn::VecFromMask(kSignedHalves, hn::Lt(before, c)),
                                    hn::VecFromMask(kSignedHalves, hn::Lt(after, c)));
    const Halves e1 = hn::IfThenElse(hn::RebindMask(kHalves, is_one_sign), e0,
                                     hn::Sub(hn::Max(down, up), hn::Min(down, up)));
    const Halves e2 = hn::SaturatedAdd(
        hn::SaturatedAdd(distance(sample(x - across1), c), distance(sample(x + across1), c)),
        hn::SaturatedAdd(distance(sample(x - across2), c), distance(sample(x + across2), c)));
    // Activity class, and the limit that the value range sets
    const Halves g = hn::SaturatedAdd(e0, e2);
    const Halves activity = hn::Add(hn::Add(is_at_least(g, one), is_at_least(g, quarter)),
                                    hn::Add(is_at_least(g, threshold), is_at_least(g, fourfold)));
    const Halves level = hn::Xor(hn::BitCast(kHalves, c), flip);
    const Halves low = hn::Sub(level, min);
    const Halves high = hn::Sub(max, level);
    // The smaller one of the two fits in 16 bits.
    const Halves limit = hn::Min(hn::SaturatedAdd(hn::SaturatedAdd(low, low), odd_low),
                                 hn::SaturatedAdd(hn::SaturatedAdd(high, high), odd_high));
    // Kept for contexts and predictions
    const hn::Rebind<std::uint8_t, decltype(kHalves)> bytes;
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(kSignedHalves, activity)), bytes, activities + x);
    hn::StoreU(limit, kHalves, row.limit + x);
    hn::StoreU(limit, kHalves, limits + x);
    hn::StoreU(hn::Min(e0, most), kHalves, row.gradient_along + x);
    hn::StoreU(hn::Min(e1, most), kHalves, row.curvature_along + x);
    hn::StoreU(hn::Min(e2, most), kHalves, row.gradient_across + x);
  }
}

/// sums += a0 * b0 + a1 * b1 for the two 16-bit numbers in each 32-bit lane.
template <class V, class W>
HWY_INLINE W add_products(V a, V b, W sums) {
  const hn::DFromV<W> wide;
#if HWY_ARCH_X86 || HWY_ARCH_WASM
  // There this adds the products of neighboring lanes; `unused` stays 0.
  W unused = hn::Zero(wide);
  return hn::ReorderWidenMulAccumulate(wide, a, b, sums, unused);
#else
  const auto pair_a = hn::BitCast(wide, a);
  const auto pair_b = hn::BitCast(wide, b);
  const auto low = [](W v) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(v)); };
  const auto high = [](W v) { return hn::ShiftRight<16>(v); };
  return hn::Add(hn::Add(sums, hn::Mul(low(pair_a), low(pair_b))),
                 hn::Mul(high(pair_a), high(pair_b)));
#endif
}

/// Predicted magnitudes (Q8) to contexts with their plain bits, see the portable `context_of`.
template <class W>
HWY_INLINE W contexts_of(W predicted, W limit, W free_bits) {
  const hn::DFromV<W> sums;
  const hn::RebindToFloat<hn::DFromV<W>> floats;
  const auto set = [&](std::int32_t value) HWY_ATTR { return hn::Set(sums, value); };
  const auto is_limited = hn::Gt(predicted, hn::ShiftLeft<7>(hn::Sub(limit, set(1))));
  predicted = hn::Min(predicted, hn::ShiftLeft<8>(limit));
  const auto value = hn::ConvertTo(floats, hn::Add(predicted, set(8)));
  const auto half_octave =
      hn::Min(hn::Sub(hn::ShiftRight<22>(hn::BitCast(sums, value)), set(260)),
              set(kMagnitudes - 1));
  const auto plain = hn::Min(hn::Max(hn::Sub(hn::ShiftRight<1>(half_octave), free_bits), set(0)),
                             set(kMaxPlainBits));
  return hn::Add(hn::Add(half_octave, hn::IfThenElseZero(is_limited, set(kMagnitudes))),
                 hn::ShiftLeft<8>(plain));
}

/// kLooksUp: whether the row above counts.
template <bool kLooksUp>
void contexts_of_row(const std::int32_t* w, const Stage& stage, const MagnitudeRows& near,
                     const RowBuffers& row, std::uint16_t* out) {
  const int count = static_cast<int>(stage.pairs.x);
  const SignedSums free_bits = hn::Set(kSignedSums, 6 + stage.step_bits);
  const auto pair = [w](int k) {
    const auto low = static_cast<std::uint32_t>(w[k]);
    const auto high = static_cast<std::uint32_t>(w[k + 1]) << 16;
    return hn::BitCast(kSignedHalves, hn::Set(kSums, low | high));
  };
  const SignedHalves w01 = pair(0), w23 = pair(2), w45 = pair(4), w67 = pair(6), w89 = pair(8),
                     w1011 = pair(10), w1213 = pair(12), w1415 = pair(14);
  const SignedHalves w011 =
      hn::BitCast(kSignedHalves, hn::Set(kSums, static_cast<std::uint32_t>(w[11]) << 16));
  const SignedHalves one = hn::Set(kSignedHalves, 1);
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kHalves));
  const auto feature = [](const std::uint16_t* at) {
    return hn::BitCast(kSignedHalves, hn::LoadU(kHalves, at));
  };
  const auto magnitude = [](const std::int16_t* at) { return hn::LoadU(kSignedHalves, at); };
  for (int x = 0; x < count; x += kLanes) {
    // The expected magnitude: features and earlier residuals, weighted
    SignedSums lower = hn::Zero(kSignedSums);
    SignedSums upper = hn::Zero(kSignedSums);
    const auto add = [&](SignedHalves a, SignedHalves b, SignedHalves weights) HWY_ATTR {
      lower = add_products(hn::InterleaveLower(kSignedHalves, a, b), weights, lower);
      upper = add_products(hn::InterleaveUpper(kSignedHalves, a, b), weights, upper);
    };
    add(feature(row.gradient_along + x), feature(row.curvature_along + x), w01);
    add(feature(row.gradient_across + x), magnitude(near.sibling[0] + x), w23);
    add(magnitude(near.sibling[1] + x), one, w45);
    if constexpr (kLooksUp) {
      add(magnitude(near.up + x + 2), magnitude(near.up + x - 2), w67);
      add(magnitude(near.up + x), magnitude(near.up + x - 1), w89);
      add(magnitude(near.up + x + 1), magnitude(near.back + x), w1011);
    } else {
      add(one, magnitude(near.back + x), w011);
    }
    add(magnitude(near.back + x - 1), magnitude(near.back + x + 1), w1213);
    add(magnitude(near.back_up + x), magnitude(near.back_down + x), w1415);
    // Its context
    const Halves limit = hn::LoadU(kHalves, row.limit + x);
    const Halves zero = hn::Zero(kHalves);
    const auto wide = [&](Halves v) HWY_ATTR { return hn::BitCast(kSignedSums, v); };
    const auto contexts = hn::ReorderDemote2To(
        kSignedHalves,
        contexts_of(lower, wide(hn::InterleaveLower(kHalves, limit, zero)), free_bits),
        contexts_of(upper, wide(hn::InterleaveUpper(kHalves, limit, zero)), free_bits));
    hn::StoreU(hn::BitCast(kHalves, contexts), kHalves, out + x);
  }
}

template <class V>
HWY_INLINE V brought_within(V detail, V limit) {
  return hn::Min(hn::Max(detail, hn::Neg(limit)), limit);
}

/// The magnitudes of residuals, or of what saturates for them in 16 bits: the lowest number has no
/// opposite there.
template <class D>
HWY_INLINE hn::Vec<D> residual_sizes(D d, hn::Vec<D> residual) {
  if constexpr (sizeof(hn::TFromD<D>) == 2) {
    return hn::Max(residual, hn::SaturatedSub(hn::Zero(d), residual));
  } else {
    return hn::Abs(residual);
  }
}

/// residual_of for every lane, from predictions that need not be within the limit. Twice a limit
/// fits in a lane.
template <class D>
HWY_INLINE hn::Vec<D> residuals_of(D d, hn::Vec<D> detail, hn::Vec<D> prediction,
                                   hn::Vec<D> limit) {
  const auto sign = hn::BroadcastSignBit(prediction);
  const auto from = hn::Min(hn::Abs(prediction), limit);
  const auto to = hn::Sub(hn::Xor(detail, sign), sign);
  const auto residual = hn::Sub(to, from);
  const auto left = hn::Sub(limit, to);
  const auto beyond = hn::Xor(hn::ShiftRight<1>(left),
                              hn::Neg(hn::And(left, hn::Set(d, 1))));
  return hn::IfThenElse(hn::Lt(residual, hn::Sub(from, limit)), beyond, residual);
}

/// detail_of for every lane, likewise.
template <class D>
HWY_INLINE hn::Vec<D> details_of(D d, hn::Vec<D> residual, hn::Vec<D> prediction,
                                 hn::Vec<D> limit) {
  // What does not wait for the prediction
  const auto size = residual_sizes(d, residual);
  const auto room = hn::Sub(limit, size);
  const auto twice = [&]() HWY_ATTR {
    if constexpr (sizeof(hn::TFromD<D>) == 2) return hn::SaturatedAdd(size, size);
    else return hn::Add(size, size);
  }();
  const auto left = hn::Add(twice, hn::BroadcastSignBit(residual));
  const auto beyond = hn::Max(hn::Sub(limit, left), hn::Neg(limit));
  // What does, the shortest way from it
  const auto sign = hn::BroadcastSignBit(prediction);
  const auto from = brought_within(prediction, limit);
  const auto signed_residual = hn::Sub(hn::Xor(residual, sign), sign);
  const auto signed_beyond = hn::Sub(hn::Xor(beyond, sign), sign);
  return hn::IfThenElse(hn::Gt(hn::Abs(from), room), signed_beyond,
                        hn::Add(from, signed_residual));
}

/// The way from details to residuals and back: folded, or as multiples of a step above 1, see the
/// portable `quantized`.
template <class D>
class ResidualMap {
 public:
  using V = hn::Vec<D>;
  explicit HWY_INLINE ResidualMap(std::int32_t step)
      : step_(step),
        inverse_(hn::Set(kReals, 1.0f / static_cast<float>(step))),
        bias_(hn::Set(D(), rounding_bias(step))) {}

  /// Turns a detail into the one that a decoder will have. Predictions are brought within the
  /// limit, here and below.
  HWY_INLINE V residual(V& detail, V prediction, V limit) const {
    detail = brought_within(detail, limit);
    if (step_ == 1) return residuals_of(D(), detail, prediction, limit);
    const V from = brought_within(prediction, limit);
    const V residual = quantized(hn::Sub(detail, from));
    detail = brought_within(hn::Add(from, residual), limit);
    return residual;
  }
  HWY_INLINE V detail(V residual, V prediction, V limit) const {
    if (step_ == 1) return details_of(D(), residual, prediction, limit);
    return brought_within(hn::Add(brought_within(prediction, limit), residual), limit);
  }

 private:
  HWY_INLINE V quantized(V residual) const {
    const auto magnitude = hn::Add(hn::Abs(residual), bias_);
    const auto count = hn::ConvertTo(D(), hn::Mul(hn::ConvertTo(kReals, magnitude), inverse_));
    const auto multiple = hn::Mul(count, hn::Set(D(), step_));
    return hn::IfThenElse(hn::Lt(residual, hn::Zero(D())), hn::Neg(multiple), multiple);
  }

  static constexpr hn::RebindToFloat<D> kReals{};
  std::int32_t step_;
  hn::Vec<hn::RebindToFloat<D>> inverse_;
  hn::Vec<D> bias_;
};

/// Magnitudes of a row of residuals.
inline void magnitudes_of_row(const std::int32_t* residuals, int count, std::int16_t* magnitudes) {
  const hn::RebindToSigned<decltype(kWords)> signed_words;
  const hn::Rebind<std::int16_t, decltype(kWords)> short_words;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kWords));
  for (int x = 0; x < count; x += kLanes) {
    // As unsigned numbers: a damaged residual may be the lowest one, which is its own opposite.
    const Words size = hn::BitCast(kWords, hn::Abs(hn::LoadU(signed_words, residuals + x)));
    const auto magnitude =
        hn::BitCast(signed_words, hn::Min(size, hn::Set(kWords, kMaxMagnitude)));
    hn::StoreU(hn::DemoteTo(short_words, magnitude), short_words, magnitudes + x);
  }
}

/// Pairs where values have gaps: predictions and residuals to details, or predictions and details
/// to residuals. The means are those of as many pairs as there are lanes.
template <bool kIsEncoding, class D>
HWY_INLINE hn::Vec<D> through_gaps(D d, const ValueGaps& gaps, const std::int16_t* means,
                                   hn::Vec<D> prediction, hn::Vec<D> given) {
  alignas(64) std::int32_t predictions[hn::MaxLanes(d)];
  alignas(64) std::int32_t numbers[hn::MaxLanes(d)];
  hn::Store(prediction, d, predictions);
  hn::Store(given, d, numbers);
  for (std::size_t k = 0; k < hn::MaxLanes(d); ++k) {
    const ValueGaps::Details& possible = gaps.of(means[k]);
    const int nearest = possible.nearest(predictions[k]);
    if constexpr (kIsEncoding) {
      numbers[k] = folded(possible.nearest(numbers[k]), nearest, possible.last);
    } else {
      numbers[k] = possible.detail(unfolded<int>(numbers[k], nearest, possible.last));
    }
  }
  return hn::Load(d, numbers);
}

/// Prediction from means: a row of residuals to samples, or of details to residuals and samples.
template <int kAxis, bool kIsEncoding>
void reconstruct_from_means(const Parameters& p, const Stage& stage,
                            Workspace<std::int16_t>& work, std::int64_t y, std::int64_t z) {
  const hn::RebindToSigned<decltype(kWords)> ints;
  const hn::Rebind<std::int16_t, decltype(kWords)> shorts;
  const hn::Rebind<std::uint16_t, decltype(kWords)> unsigned_shorts;
  const hn::Rebind<std::uint8_t, decltype(kWords)> bytes;
  constexpr std::int64_t kStep = pair_step<std::int16_t>(kAxis);
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kWords));
  // Four classes have weights; lane k of the table is class k + 1.
  alignas(64) std::int32_t class_weights[8] = {};
  alignas(64) std::int32_t class_behind_weights[8] = {};
  for (int k = 1; k < kClasses; ++k) {
    class_weights[(k - 1) % kLanes] = p.mean_weights[stage.group][kAxis][k];
    class_behind_weights[(k - 1) % kLanes] = p.behind_weights[stage.group][kAxis][k];
  }
  const auto weights = hn::Load(ints, class_weights);
  const auto behind_weights = hn::Load(ints, class_behind_weights);
  const auto set = [&](std::int32_t value) HWY_ATTR { return hn::Set(ints, value); };
  const std::uint8_t* const activities = work.activities.row(y, z);
  const std::uint16_t* const limits = work.limits.row(y, z);
  std::int32_t* const residuals = work.residuals.row(y, z);
  const std::int32_t* const edges = edge_details(stage, work, y, z);
  std::int16_t* const first = first_of_row(work.fine, kAxis, y, z);
  const std::int16_t* const means = work.means.row(y, z);
  std::int32_t* const excesses = work.excesses.row(y, z);
  const auto widen = [&](const std::int16_t* from) HWY_ATTR {
    return hn::PromoteTo(ints, hn::LoadU(shorts, from));
  };
  const auto far_share = set(p.far_shares[stage.group][kAxis]);
  const auto share_of = [&](auto number, auto share) HWY_ATTR {
    return hn::ShiftRight<kShareBits>(hn::Add(hn::Mul(number, share), set(kHalfShare)));
  };
  const ResidualMap<decltype(ints)> map(stage.step);
  for (int x = 0; x < stage.pairs.x; x += kLanes) {
    // Predict from the slope of the means
    const auto mean = widen(means + x);
    const auto near = hn::Sub(widen(means + x - kStep), widen(means + x + kStep));
    const auto far = hn::Sub(widen(means + x - 2 * kStep), widen(means + x + 2 * kStep));
    const auto slope = hn::Add(near, share_of(far, far_share));
    const auto activity = hn::PromoteTo(ints, hn::LoadU(bytes, activities + x));
    const auto place = hn::And(hn::Sub(activity, set(1)), set(3));
    const auto has_weights = hn::Gt(activity, hn::Zero(ints));
    const auto places = hn::IndicesFromVec(ints, place);
    const auto weight = hn::IfThenElseZero(has_weights, hn::TableLookupLanes(weights, places));
    const auto behind_weight =
        hn::IfThenElseZero(has_weights, hn::TableLookupLanes(behind_weights, places));
    const auto limit = hn::PromoteTo(ints, hn::LoadU(unsigned_shorts, limits + x));
    const auto sum = hn::Add(hn::Mul(slope, weight), set(1 << (kWeightBits - 1)));
    const auto likely = brought_within(hn::ShiftRight<kWeightBits>(sum), limit);
    const auto behind = z > 0 ? hn::LoadU(ints, excesses + x) : hn::Zero(ints);
    const auto prediction = hn::Add(likely, share_of(behind, behind_weight));
    // An edge has no room: its detail is known. Details are counted from there.
    const auto known = edges != nullptr ? hn::LoadU(ints, edges + x) : hn::Zero(ints);
    // Detail to residual, or residual to detail
    auto detail = hn::LoadU(ints, residuals + x);
    if (stage.gaps != nullptr) {
      const auto found =
          through_gaps<kIsEncoding>(ints, *stage.gaps, means + x,
                                    hn::Add(known, brought_within(prediction, limit)), detail);
      if constexpr (kIsEncoding) hn::StoreU(found, ints, residuals + x);
      else detail = found;
      detail = brought_within(hn::Sub(detail, known), limit);
    } else if constexpr (kIsEncoding) {
      detail = hn::Sub(detail, known);
      hn::StoreU(map.residual(detail, prediction, limit), ints, residuals + x);
    } else {
      detail = map.detail(detail, prediction, limit);
    }
    hn::StoreU(hn::Sub(detail, likely), ints, excesses + x);
    detail = hn::Add(detail, known);
    // Mean and detail to the two samples
    const auto round = set(stage.rounding);
    const auto total = hn::Add(hn::Sub(hn::Add(mean, mean), round),
                               hn::And(hn::Add(detail, round), set(1)));
    const auto a = hn::ShiftRight<1>(hn::Add(total, detail));
    const auto b = hn::ShiftRight<1>(hn::Sub(total, detail));
    if constexpr (kAxis == 0) {
      const auto both = hn::Or(hn::And(a, set(0xffff)), hn::ShiftLeft<16>(b));
      // The margin holds what the last vector writes beyond the row.
      alignas(64) std::int32_t out[8];
      hn::Store(both, ints, out);
      std::memcpy(first + 2 * x, out, sizeof(std::int32_t) * static_cast<std::size_t>(kLanes));
    } else {
      hn::StoreU(hn::DemoteTo(shorts, a), shorts, first + x);
      hn::StoreU(hn::DemoteTo(shorts, b), shorts, first + kStep + x);
    }
  }
  settle_weighted(stage, work, y, z, [&](std::int64_t x) {
    const std::int32_t weight = p.mean_weights[stage.group][kAxis][activities[x]];
    const std::int32_t limit = limits[x];
    const std::int32_t likely =
        predict_from_means(means + x, kStep, weight, p.far_shares[stage.group][kAxis]);
    return excesses[x] + std::clamp(likely, -limit, limit);
  });
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
