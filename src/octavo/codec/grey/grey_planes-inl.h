// Prediction from means, vectorized: all features of a plane of pairs in one go, in 16 bits.
// For ranges that leave room for sums of two samples' differences; others take the row pass.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_PLANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_PLANES_INL_H
#undef OCTAVO_CODEC_GREY_PLANES_INL_H
#else
#define OCTAVO_CODEC_GREY_PLANES_INL_H
#endif

#include <hwy/highway.h>

#include <memory>
#include <span>
#include <type_traits>

#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/grey_rows-inl.h"

// Places within a row are small numbers.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

inline constexpr int kHalfLanes = static_cast<int>(hn::MaxLanes(kHalves));

/// All pairs of a full row, where vectors are so wide.
constexpr hn::CappedTag<std::int16_t, 32> kWideHalves{};

/// Whether there are such vectors, and they reach nowhere beyond the rows of a stage.
HWY_INLINE bool has_wide_rows(const Stage& stage) {
  constexpr auto kLanes = static_cast<std::int64_t>(hn::MaxLanes(kWideHalves));
  return kLanes > kHalfLanes && stage.pairs.x % kLanes == 0;
}

/// Whether any of the pairs from x on that share a vector is among some pairs of a row.
template <class D>
HWY_INLINE bool is_any_from(D, RowMask pairs, int x) {
  return (pairs >> x & first_pairs(static_cast<int>(hn::MaxLanes(D())))) != 0;
}

/// Whether the plane pass gives what the row pass gives: differences, limits and what follows from
/// residuals fit in 16 bits, and eight times a weight does.
inline bool suits_planes(const Parameters& p, const Stage& stage) {
  const auto& weights = p.mean_weights[stage.group][stage.axis];
  const bool is_slight = std::all_of(std::begin(weights), std::end(weights),
                                     [](std::int32_t w) { return w >= -4096 && w < 4096; });
  return is_slight && stage.step == 1 && stage.shift == 0 && stage.max - stage.min <= 16382;
}

/// What a stage's parameters are in vectors.
template <class D>
struct PlaneConstants {
  static constexpr D kSigned{};
  static constexpr hn::RebindToUnsigned<D> kUnsigned{};
  static constexpr hn::RepartitionToWide<D> kWide{};
  using V = hn::Vec<D>;

  /// Rising; the class is the number of those reached.
  hn::Vec<hn::RebindToUnsigned<D>> thresholds[kClasses - 1];
  V class_weights[kClasses];
  V behind_weights[kClasses];
  V far_share;
  V min, max, range, odd_low, odd_high;
  V pairs[kFeatures / 2];  ///< context weights, two by two
  hn::Vec<hn::RepartitionToWide<D>> constant;

  HWY_INLINE PlaneConstants(const Parameters& p, const Stage& stage) {
    const auto set = [](std::int64_t v) HWY_ATTR {
      return hn::Set(kSigned, static_cast<std::int16_t>(v));
    };
    constexpr std::int32_t kShareUnit = 1 << (15 - kShareBits);
    const std::int32_t t = p.activity_threshold;
    const std::int32_t rising[] = {std::min(1, t / 4), std::max(1, t / 4), t, 4 * t};
    for (int k = 0; k < kClasses; ++k) {
      if (k > 0) thresholds[k - 1] = hn::BitCast(kUnsigned, set(rising[k - 1]));
      class_weights[k] = set(k == 0 ? 0 : 8 * p.mean_weights[stage.group][stage.axis][k]);
      behind_weights[k] =
          set(k == 0 ? 0 : kShareUnit * p.behind_weights[stage.group][stage.axis][k]);
    }
    far_share = set(kShareUnit * p.far_shares[stage.group][stage.axis]);
    min = set(stage.min);
    max = set(stage.max);
    range = set(stage.max - stage.min);
    odd_low = set(stage.odd_low);
    odd_high = set(stage.odd_high);
    const std::int32_t* const w = p.context_weights[stage.group][stage.axis];
    constexpr int kPairs[][2] = {{0, 1}, {2, 3}, {4, 11}, {12, 13}, {14, 15}, {2, 11}};
    for (std::size_t k = 0; k < std::size(kPairs); ++k) {
      const auto low = static_cast<std::uint32_t>(w[kPairs[k][0]]);
      const auto high = static_cast<std::uint32_t>(w[kPairs[k][1]]) << 16;
      pairs[k] = hn::BitCast(kSigned, hn::Set(hn::RepartitionToWide<decltype(kUnsigned)>(),
                                             low | high));
    }
    constant = hn::Set(kWide, w[5]);
  }
};

/// contexts_of for two vectors of predicted magnitudes, which stand as InterleaveLower and -Upper
/// leave them; of details that are multiples of 1. No limit is below 0.
template <class D, class Sums>
HWY_INLINE hn::Vec<D> contexts_of_halves(D d, Sums lower, Sums upper, hn::Vec<D> limit) {
  const hn::RepartitionToWide<D> sums;
  const hn::RebindToFloat<decltype(sums)> floats;
  const hn::RebindToUnsigned<D> u;
  const auto set = [](std::int16_t value) HWY_ATTR { return hn::Set(D(), value); };
  const auto add = [&](Sums v, std::int32_t more) HWY_ATTR {
    return hn::Add(v, hn::Set(sums, more));
  };
  // In units of 128, rounded up: what does not fit in 16 bits is not below any limit.
  const auto units = hn::ReorderDemote2To(d, hn::ShiftRight<7>(add(lower, 127)),
                                          hn::ShiftRight<7>(add(upper, 127)));
  // Half-octaves of 32 bits, what follows from them of 16
  const auto exponents = [&](Sums predicted, hn::Vec<D> limits) HWY_ATTR {
    const auto bounded = hn::Min(predicted, hn::ShiftLeft<8>(hn::BitCast(sums, limits)));
    return hn::ShiftRight<22>(hn::BitCast(sums, hn::ConvertTo(floats, add(bounded, 8))));
  };
  const auto zero = hn::Zero(d);
  const auto found = hn::ReorderDemote2To(d, exponents(lower, hn::InterleaveLower(d, limit, zero)),
                                          exponents(upper, hn::InterleaveUpper(d, limit, zero)));
  const auto half_octave = hn::Min(hn::Sub(found, set(260)), set(kMagnitudes - 1));
  const auto octave = hn::BitCast(u, hn::ShiftRight<1>(half_octave));
  const auto plain =
      hn::Min(hn::BitCast(d, hn::SaturatedSub(octave, hn::Set(u, 6))), set(kMaxPlainBits));
  const auto bank = hn::IfThenZeroElse(hn::Lt(units, limit), set(kMagnitudes));
  return hn::Add(hn::Add(half_octave, bank), hn::ShiftLeft<8>(plain));
}

/// Predictions, limits and contexts of a plane. What is predicted from slopes alone takes the place
/// of the excesses behind. Where all pairs of a vector lie in uniform cells nothing is predicted,
/// nor in rows that nobody looks at.
template <int kAxis, class D>
void prepare_rows(D d, const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                  std::int64_t z) {
  const hn::RebindToUnsigned<D> u;
  using V = hn::Vec<D>;
  using U = hn::Vec<hn::RebindToUnsigned<D>>;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  constexpr std::int64_t kAlong = pair_step<std::int16_t>(kAxis);
  constexpr std::int64_t kAcross1 = pair_step<std::int16_t>(kAxis == 0 ? 1 : 0);
  constexpr std::int64_t kAcross2 = pair_step<std::int16_t>(kAxis == 2 ? 1 : 2);
  const PlaneConstants<D> constants(p, stage);
  const U most = hn::Set(u, kMaxFeature);
  for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
    const MagnitudeRows near = magnitude_rows(work.magnitudes, p.predictor, kAxis, y, z,
                                              work.row.zeros + 8);
    const std::int16_t* const m = work.means.row(y, z);
    std::int16_t* const predictions = work.predictions.row(y, z);
    std::int16_t* const excesses = work.plane_excesses.row(y, z);
    std::uint16_t* const limits = work.limits.row(y, z);
    std::uint16_t* const contexts = work.contexts.row(y, z);
    const auto weighted = static_cast<std::int16_t>(stage.first_weighted(y, z));
    const RowMask open = open_pairs(stage, work, y, z);
    const bool is_predicted = stage.is_looked_at(y);
    for (int x = 0; x < stage.pairs.x; x += kLanes) {
      if (!is_any_from(d, open, x)) {
        // An encoder looks at them: the lowest number, which others may have left, has no opposite.
        hn::StoreU(hn::Zero(d), d, predictions + x);
        hn::StoreU(hn::Zero(d), d, excesses + x);
        hn::StoreU(hn::Zero(u), u, limits + x);
        continue;
      }
      const V c = hn::LoadU(d, m + x);
      const auto step_to = [&](std::int64_t offset) HWY_ATTR {
        return hn::Sub(hn::LoadU(d, m + x + offset), c);
      };
      const auto size_of = [&](V v) HWY_ATTR {
        return hn::BitCast(u, hn::Abs(v));
      };
      // Steps between the means around, along the split and across it
      const V before = step_to(-kAlong);
      const V after = step_to(kAlong);
      const U e0 = hn::Add(size_of(before), size_of(after));
      const U e1 = size_of(hn::Add(before, after));
      const U e2 = hn::Add(hn::Add(size_of(step_to(-kAcross1)), size_of(step_to(kAcross1))),
                                hn::Add(size_of(step_to(-kAcross2)), size_of(step_to(kAcross2))));

      // What the value range allows
      const V low = hn::Sub(c, constants.min);
      const V high = hn::Sub(constants.max, c);
      V limit = hn::Min(hn::Add(hn::Add(low, low), constants.odd_low),
                                   hn::Add(hn::Add(high, high), constants.odd_high));
      if (x + kLanes > weighted) {
        const V places = hn::Iota(d, static_cast<std::int16_t>(x));
        const auto is_before = hn::Lt(places, hn::Set(d, weighted));
        limit = hn::IfThenElse(is_before, limit, constants.range);
      }
      if (is_predicted) {
        // The weights of the activity class
        const U g = hn::SaturatedAdd(e0, e2);
        V weight = constants.class_weights[0];
        V behind_weight = constants.behind_weights[0];
        for (int k = 1; k < kClasses; ++k) {
          const auto is_reached =
              hn::RebindMask(d, hn::Eq(hn::Max(g, constants.thresholds[k - 1]), g));
          weight = hn::IfThenElse(is_reached, constants.class_weights[k], weight);
          behind_weight = hn::IfThenElse(is_reached, constants.behind_weights[k], behind_weight);
        }
        // The prediction
        const V far =
            hn::Sub(hn::LoadU(d, m + x - 2 * kAlong), hn::LoadU(d, m + x + 2 * kAlong));
        const V slope =
            hn::Add(hn::Sub(before, after), hn::MulFixedPoint15(far, constants.far_share));
        const V likely = brought_within(hn::MulFixedPoint15(slope, weight), limit);
        const V behind = z > 0 ? hn::LoadU(d, excesses + x) : hn::Zero(d);
        const V expected =
            hn::SaturatedAdd(likely, hn::MulFixedPoint15(behind, behind_weight));
        hn::StoreU(likely, d, excesses + x);
        hn::StoreU(brought_within(expected, limit), d, predictions + x);
        hn::StoreU(hn::BitCast(u, limit), u, limits + x);
      }

      // The expected magnitude: features and earlier residuals, weighted
      auto lower = constants.constant;
      auto upper = constants.constant;
      const auto add = [&](V a, V b, V weights) HWY_ATTR {
        lower = add_products(hn::InterleaveLower(d, a, b), weights, lower);
        upper = add_products(hn::InterleaveUpper(d, a, b), weights, upper);
      };
      const auto feature = [&](U v) HWY_ATTR {
        return hn::BitCast(d, hn::Min(v, most));
      };
      const auto magnitude = [&](const std::int16_t* row) HWY_ATTR {
        return hn::LoadU(d, row + x);
      };
      add(feature(e0), feature(e1), constants.pairs[0]);
      if constexpr (kAxis == 2) {
        add(feature(e2), magnitude(near.back), constants.pairs[5]);
      } else {
        add(feature(e2), magnitude(near.sibling[0]), constants.pairs[1]);
        add(kAxis == 0 ? magnitude(near.sibling[1]) : hn::Zero(d),
            magnitude(near.back), constants.pairs[2]);
      }
      add(magnitude(near.back - 1), magnitude(near.back + 1), constants.pairs[3]);
      add(magnitude(near.back_up), magnitude(near.back_down), constants.pairs[4]);
      // Its context
      const V found = contexts_of_halves(d, lower, upper, limit);
      hn::StoreU(hn::BitCast(u, found), u, contexts + x);
    }
  }
}

template <int kAxis>
void prepare_plane(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   std::int64_t z) {
  if (has_wide_rows(stage)) prepare_rows<kAxis>(kWideHalves, p, stage, work, z);
  else prepare_rows<kAxis>(kSignedHalves, p, stage, work, z);
}

/// As many numbers as there are halves; they fit in 16 bits.
template <class D>
HWY_INLINE hn::Vec<D> load_narrowed(D d, const std::int32_t* from) {
  const auto narrowed = [](const std::int32_t* at) HWY_ATTR {
    return hn::DemoteTo(hn::Half<D>(), hn::LoadU(hn::RepartitionToWide<D>(), at));
  };
  return hn::Combine(d, narrowed(from + hn::MaxLanes(d) / 2), narrowed(from));
}

/// A row of pairs once its details are known.
template <int kAxis, class D>
class PairRow {
 public:
  using V = hn::Vec<D>;

  HWY_INLINE PairRow(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y,
                     std::int64_t z)
      : means_(work.means.row(y, z)),
        predictions_(work.predictions.row(y, z)),
        excesses_(work.plane_excesses.row(y, z)),
        limits_(work.limits.row(y, z)),
        magnitudes_(work.magnitudes[kAxis].row(y, z)),
        edges_(edge_details(stage, work, y, z)),
        first_(first_of_row(work.fine, kAxis, y, z)),
        up_(hn::Set(kSigned, static_cast<std::int16_t>(1 - stage.rounding))) {}

  HWY_INLINE V prediction(int x) const {
    return hn::LoadU(kSigned, predictions_ + x);
  }
  HWY_INLINE V limit(int x) const {
    return hn::BitCast(kSigned, hn::LoadU(hn::RebindToUnsigned<D>(), limits_ + x));
  }
  /// An edge has no room: its detail is known. Details are counted from there.
  HWY_INLINE V known(int x) const {
    return edges_ != nullptr ? load_narrowed(kSigned, edges_ + x) : hn::Zero(kSigned);
  }

  /// Where nothing is coded, nor predicted.
  HWY_INLINE void repeat_means(int x) const { put_samples(x, hn::Zero(kSigned)); }

  HWY_INLINE V keep_magnitudes(int x, V residual) const {
    const V size = residual_sizes(kSigned, residual);
    const V magnitudes = hn::Min(size, hn::Set(kSigned, kMaxMagnitude));
    hn::StoreU(magnitudes, kSigned, magnitudes_ + x);
    return magnitudes;
  }

  /// fill_margins, out of the first and the last vector of magnitudes: to load a number so soon
  /// after it was stored in a vector would stall.
  HWY_INLINE void put_margins(V first, V last, int count) const {
    const auto put_two = [](std::int16_t number, std::int16_t* to) {
      to[0] = to[1] = number;
    };
    constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
    put_two(hn::GetLane(first), magnitudes_ - 2);
    const bool is_full = count % kLanes == 0;
    put_two(is_full ? hn::GetLane(hn::Reverse(kSigned, last)) : magnitudes_[count - 1],
            magnitudes_ + count);
  }

  /// detail: less a known one
  HWY_INLINE void keep_excess(int x, V detail) const {
    const V likely = hn::LoadU(kSigned, excesses_ + x);
    hn::StoreU(hn::Sub(detail, brought_within(likely, limit(x))), kSigned, excesses_ + x);
  }

  /// pair_of, in other words: half of an odd detail is rounded as the mean was not.
  HWY_INLINE void put_samples(int x, V detail) const {
    const V mean = hn::LoadU(kSigned, means_ + x);
    const V a = hn::Add(mean, hn::ShiftRight<1>(hn::Add(detail, up_)));
    const V b = hn::Sub(a, detail);
    if constexpr (kAxis == 0) {
      hn::StoreInterleaved2(a, b, kSigned, first_ + 2 * x);
    } else {
      hn::StoreU(a, kSigned, first_ + x);
      hn::StoreU(b, kSigned, first_ + pair_step<std::int16_t>(kAxis) + x);
    }
  }

 private:
  static constexpr D kSigned{};

  const std::int16_t* means_;
  const std::int16_t* predictions_;
  std::int16_t* excesses_;
  const std::uint16_t* limits_;
  std::int16_t* magnitudes_;
  const std::int32_t* edges_;
  std::int16_t* first_;
  V up_;
};

/// Residuals of the rows from y to end - 1, which follow one another, to samples and magnitudes.
template <int kAxis, class D>
HWY_NOINLINE void settle_pairs(D d, const Stage& stage, Workspace<std::int16_t>& work,
                               const std::int16_t* residuals, std::int64_t y, std::int64_t end,
                               std::int64_t z) {
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  const auto count = static_cast<int>(stage.pairs.x);
  for (; y < end; ++y, residuals += count) {
    const PairRow<kAxis, D> row(stage, work, y, z);
    const bool is_looked_at = stage.is_looked_at(y);
    const RowMask open = open_pairs(stage, work, y, z);
    auto first = hn::Zero(d);
    auto last = hn::Zero(d);
    for (int x = 0; x < count; x += kLanes) {
      const bool is_open = is_any_from(d, open, x);
      // No residual is coded of other pairs.
      const auto residual = is_open ? hn::LoadU(d, residuals + x) : hn::Zero(d);
      last = row.keep_magnitudes(x, residual);
      if (x == 0) first = last;
      if (!is_looked_at) continue;
      if (!is_open) {
        row.repeat_means(x);
        continue;
      }
      const auto detail = details_of(d, residual, row.prediction(x), row.limit(x));
      row.keep_excess(x, detail);
      row.put_samples(x, hn::Add(detail, row.known(x)));
    }
    row.put_margins(first, last, count);
  }
}

template <int kAxis>
void settle_rows(const Stage& stage, Workspace<std::int16_t>& work, const std::int16_t* residuals,
                 std::int64_t y, std::int64_t end, std::int64_t z) {
  if (has_wide_rows(stage)) {
    settle_pairs<kAxis>(kWideHalves, stage, work, residuals, y, end, z);
  } else {
    settle_pairs<kAxis>(kSignedHalves, stage, work, residuals, y, end, z);
  }
}

/// The details in work.residuals to residuals, samples and magnitudes.
template <int kAxis>
void predict_row(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y,
                 std::int64_t z) {
  const PairRow<kAxis, decltype(kSignedHalves)> row(stage, work, y, z);
  std::int32_t* const details = work.residuals.row(y, z);
  alignas(64) std::int16_t residuals[kHalfLanes];
  for (int x = 0; x < stage.pairs.x; x += kHalfLanes) {
    const SignedHalves given = hn::Sub(load_narrowed(kSignedHalves, details + x), row.known(x));
    const SignedHalves detail = brought_within(given, row.limit(x));
    const SignedHalves residual =
        residuals_of(kSignedHalves, detail, row.prediction(x), row.limit(x));
    row.keep_magnitudes(x, residual);
    row.keep_excess(x, detail);
    row.put_samples(x, hn::Add(detail, row.known(x)));
    hn::Store(residual, kSignedHalves, residuals);
    const int last = static_cast<int>(std::min<std::int64_t>(stage.pairs.x - x, kHalfLanes));
    for (int k = 0; k < last; ++k) details[x + k] = residuals[k];
  }
}

/// The pairs of two weights of a row that has been settled or predicted.
template <class Residual>
void settle_weighted_row(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y,
                         std::int64_t z, const Residual* residuals) {
  if (stage.first_weighted(y, z) >= stage.pairs.x || !stage.is_looked_at(y)) return;
  const std::int16_t* const predictions = work.predictions.row(y, z);
  const std::uint16_t* const limits = work.limits.row(y, z);
  settle_weighted(stage, work, y, z, [&](std::int64_t x) {
    const std::int32_t limit = limits[x];
    const std::int32_t expected = std::clamp<std::int32_t>(predictions[x], -limit, limit);
    return detail_of<std::int32_t>(residuals[x], expected, limit);
  });
}

/// Turns the details of a plane into residuals, samples and magnitudes; leaves the contexts.
template <int kAxis>
void predict_plane(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   std::int64_t z) {
  prepare_plane<kAxis>(p, stage, work, z);
  for (std::int64_t y = 0; y < stage.pairs.y; ++y) {
    close_limits(coded_pairs(stage, work, y, z), stage.pairs.x, work.limits.row(y, z));
    predict_row<kAxis>(stage, work, y, z);
    settle_weighted_row(stage, work, y, z, work.residuals.row(y, z));
    fill_margins(work.magnitudes[kAxis].row(y, z), stage.pairs.x);
  }
}

/// A plane of pairs on its way from contexts to samples, some rows at a time.
template <int kAxis>
class PlaneDecoder {
 public:
  PlaneDecoder(const Parameters& p, const SplitTask<std::int16_t>& task, std::int64_t z)
      : stage_(task.stage), work_(task.work), symbols_(task.symbols), z_(z) {
    prepare_plane<kAxis>(p, stage_, work_, z);
  }

  SymbolReader& symbols() { return symbols_; }

  /// The symbols of the next rows, as many rows as may be taken unchecked; of none at the end.
  TokenRows gather() {
    first_ = last_;
    coded_ = 0;
    if (last_ == stage_.pairs.y) return {};
    const auto count = static_cast<int>(stage_.pairs.x);
    if (stage_.cells == nullptr && !stage_.has_edges) {
      // All pairs of all rows
      const auto rows = std::min<std::int64_t>(stage_.pairs.y - last_, kMaxUnchecked / count);
      std::fill_n(counts_, rows, count);
      std::fill_n(pairs_, rows, first_pairs(count));
      last_ += rows;
      coded_ = count * static_cast<int>(rows);
    }
    while (last_ < stage_.pairs.y && coded_ + count <= kMaxUnchecked) count_row(last_++);
    is_all_coded_ = coded_ == count * row_count();
    TokenRows rows{counts_, row_count(), contexts_, tokens_};
    if (is_all_coded_ && count % kChunk == 0) {
      // They stand side by side already.
      rows.contexts = work_.contexts.row(first_, z_);
      const bool is_one_row = (static_cast<std::size_t>(count) & symbols_.state_mask) == 0;
      if (is_one_row && rows.row_count > 0) {
        // Every row starts with the first state: to the streams they are one.
        counts_[0] = coded_;
        rows.row_count = 1;
      }
    } else {
      gather_rows();
    }
    contexts_of_all_ = rows.contexts;
    return rows;
  }

  /// The samples of the rows whose tokens were taken.
  void settle(bool has_big) {
    // What is behind the last residual takes part in vectors.
    hn::StoreU(hn::Zero(kChunkHalves), kChunkHalves, tokens_ + coded_);
    for (int i = coded_ & ~(kChunk - 1); i < coded_ + 2 * kHalfLanes; i += kChunk) {
      hn::StoreU(hn::Zero(kChunkResiduals), kChunkResiduals, residuals_ + i);
    }
    finish_residuals(symbols_, contexts_of_all_, tokens_, coded_, has_big, residuals_);
    symbols_.expect_inside();
    const auto count = static_cast<int>(stage_.pairs.x);
    const std::int16_t* found = residuals_;
    if (is_all_coded_) settle_rows<kAxis>(stage_, work_, found, first_, last_, z_);
    alignas(64) std::int16_t spread[kBrickSide + 2 * kHalfLanes] = {};
    for (std::int64_t y = first_; y < last_; ++y) {
      if (is_all_coded_) {
        settle_weighted_row(stage_, work_, y, z_, found);
        found += count;
        continue;
      }
      const RowMask pairs = pairs_[y - first_];
      spread_residuals(pairs, count, found, spread);
      settle_rows<kAxis>(stage_, work_, spread, y, y + 1, z_);
      settle_weighted_row(stage_, work_, y, z_, spread);
      found += std::popcount(pairs);
    }
  }

 private:
  static constexpr hn::FixedTag<std::int16_t, kChunk> kChunkResiduals{};

  int row_count() const { return static_cast<int>(last_ - first_); }

  void count_row(std::int64_t y) {
    const RowMask pairs = coded_pairs(stage_, work_, y, z_);
    close_limits(pairs, stage_.pairs.x, work_.limits.row(y, z_));
    const int coded = std::popcount(pairs);
    pairs_[y - first_] = pairs;
    counts_[y - first_] = coded;
    coded_ += coded;
  }
  void gather_rows() {
    std::uint16_t* to = contexts_;
    for (std::int64_t y = first_; y < last_; ++y) {
      gather_contexts(pairs_[y - first_], static_cast<int>(stage_.pairs.x),
                      work_.contexts.row(y, z_), to);
      to += counts_[y - first_];
    }
  }
  const Stage& stage_;
  Workspace<std::int16_t>& work_;
  SymbolReader& symbols_;
  std::int64_t z_;
  std::int64_t first_ = 0;  ///< the rows on their way
  std::int64_t last_ = 0;
  int coded_ = 0;
  bool is_all_coded_ = false;
  const std::uint16_t* contexts_of_all_ = nullptr;
  RowMask pairs_[kBrickSide];
  int counts_[kBrickSide];
  alignas(64) std::uint16_t contexts_[kMaxUnchecked + 2 * kChunk];
  alignas(64) std::uint16_t tokens_[kMaxUnchecked + 2 * kChunk];
  alignas(64) std::int16_t residuals_[kMaxUnchecked + 4 * kHalfLanes];
};

/// Decodes a plane of pairs: all contexts, then all residuals and samples.
template <int kAxis>
void decode_plane(const Parameters& p, const SplitTask<std::int16_t>& task, std::int64_t z) {
  PlaneDecoder<kAxis> plane(p, task, z);
  for (TokenRows rows = plane.gather(); rows.row_count > 0; rows = plane.gather()) {
    plane.settle(take_token_rows(plane.symbols(), rows));
  }
}

/// Room for a decoder, which clears nothing.
template <int kAxis>
union PlaneRoom {
  PlaneRoom() {}
  PlaneDecoder<kAxis> decoder;
};

/// The same of several splits, whose streams do not wait for each other.
template <int kAxis>
void decode_planes(const Parameters& p, std::span<const SplitTask<std::int16_t>> tasks,
                   std::int64_t z) {
  static_assert(std::is_trivially_destructible_v<PlaneDecoder<kAxis>>);
  PlaneRoom<kAxis> planes[kMostTogether];
  StreamRows streams[kMostTogether];
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    std::construct_at(&planes[i].decoder, p, tasks[i], z);
  }
  while (true) {
    int row_count = 0;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      streams[i] = {&planes[i].decoder.symbols(), planes[i].decoder.gather()};
      row_count += streams[i].rows.row_count;
    }
    if (row_count == 0) return;
    take_token_rows(std::span(streams, tasks.size()));
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (streams[i].rows.row_count > 0) planes[i].decoder.settle(streams[i].has_big);
    }
  }
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
