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

/// Whether any of the pairs from x on that share a vector is among some pairs of a row.
HWY_INLINE bool is_any_from(RowMask pairs, int x) {
  return (pairs >> x & first_pairs(kHalfLanes)) != 0;
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
struct PlaneConstants {
  Halves thresholds[kClasses - 1];  ///< rising; the class is the number of those reached
  SignedHalves class_weights[kClasses];
  SignedHalves behind_weights[kClasses];
  SignedHalves far_share;
  SignedHalves min, max, range, odd_low, odd_high;
  SignedHalves pairs[kFeatures / 2];  ///< context weights, two by two
  SignedSums constant;
  SignedSums free_bits;

  HWY_INLINE PlaneConstants(const Parameters& p, const Stage& stage) {
    const auto set = [](std::int64_t v) HWY_ATTR {
      return hn::Set(kSignedHalves, static_cast<std::int16_t>(v));
    };
    constexpr std::int32_t kShareUnit = 1 << (15 - kShareBits);
    const std::int32_t t = p.activity_threshold;
    const std::int32_t rising[] = {std::min(1, t / 4), std::max(1, t / 4), t, 4 * t};
    for (int k = 0; k < kClasses; ++k) {
      if (k > 0) thresholds[k - 1] = hn::BitCast(kHalves, set(rising[k - 1]));
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
      pairs[k] = hn::BitCast(kSignedHalves, hn::Set(kSums, low | high));
    }
    constant = hn::Set(kSignedSums, w[5]);
    free_bits = hn::Set(kSignedSums, 6);
  }
};

/// Predictions, limits and contexts of a plane. What is predicted from slopes alone takes the place
/// of the excesses behind. Where all pairs of a vector lie in uniform cells nothing is predicted.
template <int kAxis>
void prepare_plane(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                   std::int64_t z) {
  constexpr std::int64_t kAlong = pair_step<std::int16_t>(kAxis);
  constexpr std::int64_t kAcross1 = pair_step<std::int16_t>(kAxis == 0 ? 1 : 0);
  constexpr std::int64_t kAcross2 = pair_step<std::int16_t>(kAxis == 2 ? 1 : 2);
  const PlaneConstants constants(p, stage);
  const Halves most = hn::Set(kHalves, kMaxFeature);
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
    for (int x = 0; x < stage.pairs.x; x += kHalfLanes) {
      if (!is_any_from(open, x)) {
        hn::StoreU(hn::Zero(kSignedHalves), kSignedHalves, excesses + x);
        hn::StoreU(hn::Zero(kHalves), kHalves, limits + x);
        continue;
      }
      const SignedHalves c = hn::LoadU(kSignedHalves, m + x);
      const auto step_to = [&](std::int64_t offset) HWY_ATTR {
        return hn::Sub(hn::LoadU(kSignedHalves, m + x + offset), c);
      };
      const auto size_of = [](SignedHalves v) HWY_ATTR {
        return hn::BitCast(kHalves, hn::Abs(v));
      };
      // Steps between the means around, along the split and across it
      const SignedHalves before = step_to(-kAlong);
      const SignedHalves after = step_to(kAlong);
      const Halves e0 = hn::Add(size_of(before), size_of(after));
      const Halves e1 = size_of(hn::Add(before, after));
      const Halves e2 = hn::Add(hn::Add(size_of(step_to(-kAcross1)), size_of(step_to(kAcross1))),
                                hn::Add(size_of(step_to(-kAcross2)), size_of(step_to(kAcross2))));

      // The weights of the activity class
      const Halves g = hn::SaturatedAdd(e0, e2);
      SignedHalves weight = constants.class_weights[0];
      SignedHalves behind_weight = constants.behind_weights[0];
      for (int k = 1; k < kClasses; ++k) {
        const auto is_reached = hn::RebindMask(
            kSignedHalves, hn::Eq(hn::Max(g, constants.thresholds[k - 1]), g));
        weight = hn::IfThenElse(is_reached, constants.class_weights[k], weight);
        behind_weight = hn::IfThenElse(is_reached, constants.behind_weights[k], behind_weight);
      }
      // The prediction, within what the value range allows
      const SignedHalves low = hn::Sub(c, constants.min);
      const SignedHalves high = hn::Sub(constants.max, c);
      SignedHalves limit = hn::Min(hn::Add(hn::Add(low, low), constants.odd_low),
                                   hn::Add(hn::Add(high, high), constants.odd_high));
      if (x + kHalfLanes > weighted) {
        const SignedHalves places = hn::Iota(kSignedHalves, static_cast<std::int16_t>(x));
        const auto is_before = hn::Lt(places, hn::Set(kSignedHalves, weighted));
        limit = hn::IfThenElse(is_before, limit, constants.range);
      }
      const SignedHalves far = hn::Sub(hn::LoadU(kSignedHalves, m + x - 2 * kAlong),
                                       hn::LoadU(kSignedHalves, m + x + 2 * kAlong));
      const SignedHalves slope =
          hn::Add(hn::Sub(before, after), hn::MulFixedPoint15(far, constants.far_share));
      const SignedHalves likely = brought_within(hn::MulFixedPoint15(slope, weight), limit);
      const SignedHalves behind =
          z > 0 ? hn::LoadU(kSignedHalves, excesses + x) : hn::Zero(kSignedHalves);
      const SignedHalves expected =
          hn::SaturatedAdd(likely, hn::MulFixedPoint15(behind, behind_weight));
      hn::StoreU(likely, kSignedHalves, excesses + x);
      hn::StoreU(brought_within(expected, limit), kSignedHalves, predictions + x);
      hn::StoreU(hn::BitCast(kHalves, limit), kHalves, limits + x);

      // The expected magnitude: features and earlier residuals, weighted
      SignedSums lower = constants.constant;
      SignedSums upper = constants.constant;
      const auto add = [&](SignedHalves a, SignedHalves b, SignedHalves weights) HWY_ATTR {
        lower = add_products(hn::InterleaveLower(kSignedHalves, a, b), weights, lower);
        upper = add_products(hn::InterleaveUpper(kSignedHalves, a, b), weights, upper);
      };
      const auto feature = [&](Halves v) HWY_ATTR {
        return hn::BitCast(kSignedHalves, hn::Min(v, most));
      };
      const auto magnitude = [x](const std::int16_t* row) HWY_ATTR {
        return hn::LoadU(kSignedHalves, row + x);
      };
      add(feature(e0), feature(e1), constants.pairs[0]);
      if constexpr (kAxis == 2) {
        add(feature(e2), magnitude(near.back), constants.pairs[5]);
      } else {
        add(feature(e2), magnitude(near.sibling[0]), constants.pairs[1]);
        add(kAxis == 0 ? magnitude(near.sibling[1]) : hn::Zero(kSignedHalves),
            magnitude(near.back), constants.pairs[2]);
      }
      add(magnitude(near.back - 1), magnitude(near.back + 1), constants.pairs[3]);
      add(magnitude(near.back_up), magnitude(near.back_down), constants.pairs[4]);
      // Its context
      const auto wide = [](Halves v) HWY_ATTR { return hn::BitCast(kSignedSums, v); };
      const Halves zero = hn::Zero(kHalves);
      const Halves most_detail = hn::BitCast(kHalves, limit);
      const auto found = hn::ReorderDemote2To(
          kSignedHalves,
          contexts_of(lower, wide(hn::InterleaveLower(kHalves, most_detail, zero)),
                      constants.free_bits),
          contexts_of(upper, wide(hn::InterleaveUpper(kHalves, most_detail, zero)),
                      constants.free_bits));
      hn::StoreU(hn::BitCast(kHalves, found), kHalves, contexts + x);
    }
  }
}

/// As many numbers as there are halves; they fit in 16 bits.
HWY_INLINE SignedHalves load_narrowed(const std::int32_t* from) {
  const auto narrowed = [](const std::int32_t* at) HWY_ATTR {
    return hn::DemoteTo(hn::Half<decltype(kSignedHalves)>(), hn::LoadU(kSignedSums, at));
  };
  return hn::Combine(kSignedHalves, narrowed(from + kHalfLanes / 2), narrowed(from));
}

/// A row of pairs once its details are known.
template <int kAxis>
class PairRow {
 public:
  HWY_INLINE PairRow(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y,
                     std::int64_t z)
      : means_(work.means.row(y, z)),
        predictions_(work.predictions.row(y, z)),
        excesses_(work.plane_excesses.row(y, z)),
        limits_(work.limits.row(y, z)),
        magnitudes_(work.magnitudes[kAxis].row(y, z)),
        edges_(edge_details(stage, work, y, z)),
        first_(first_of_row(work.fine, kAxis, y, z)),
        up_(hn::Set(kSignedHalves, static_cast<std::int16_t>(1 - stage.rounding))) {}

  HWY_INLINE SignedHalves prediction(int x) const {
    return hn::LoadU(kSignedHalves, predictions_ + x);
  }
  HWY_INLINE SignedHalves limit(int x) const {
    return hn::BitCast(kSignedHalves, hn::LoadU(kHalves, limits_ + x));
  }
  /// An edge has no room: its detail is known. Details are counted from there.
  HWY_INLINE SignedHalves known(int x) const {
    return edges_ != nullptr ? load_narrowed(edges_ + x) : hn::Zero(kSignedHalves);
  }

  /// Where nothing is coded, nor predicted.
  HWY_INLINE void repeat_means(int x) const {
    hn::StoreU(hn::Zero(kSignedHalves), kSignedHalves, magnitudes_ + x);
    put_samples(x, hn::Zero(kSignedHalves));
  }

  HWY_INLINE void keep_magnitudes(int x, SignedHalves residual) const {
    const SignedHalves size = residual_sizes(kSignedHalves, residual);
    hn::StoreU(hn::Min(size, hn::Set(kSignedHalves, kMaxMagnitude)), kSignedHalves,
               magnitudes_ + x);
  }

  /// detail: less a known one
  HWY_INLINE void keep_excess(int x, SignedHalves detail) const {
    const SignedHalves likely = hn::LoadU(kSignedHalves, excesses_ + x);
    hn::StoreU(hn::Sub(detail, brought_within(likely, limit(x))), kSignedHalves, excesses_ + x);
  }

  /// pair_of, in other words: half of an odd detail is rounded as the mean was not.
  HWY_INLINE void put_samples(int x, SignedHalves detail) const {
    const SignedHalves mean = hn::LoadU(kSignedHalves, means_ + x);
    const SignedHalves a = hn::Add(mean, hn::ShiftRight<1>(hn::Add(detail, up_)));
    const SignedHalves b = hn::Sub(a, detail);
    if constexpr (kAxis == 0) {
      hn::StoreInterleaved2(a, b, kSignedHalves, first_ + 2 * x);
    } else {
      hn::StoreU(a, kSignedHalves, first_ + x);
      hn::StoreU(b, kSignedHalves, first_ + pair_step<std::int16_t>(kAxis) + x);
    }
  }

 private:
  const std::int16_t* means_;
  const std::int16_t* predictions_;
  std::int16_t* excesses_;
  const std::uint16_t* limits_;
  std::int16_t* magnitudes_;
  const std::int32_t* edges_;
  std::int16_t* first_;
  SignedHalves up_;
};

/// Residuals of a row to samples and magnitudes.
template <int kAxis>
void settle_row(const Stage& stage, Workspace<std::int16_t>& work, const std::int16_t* residuals,
                std::int64_t y, std::int64_t z) {
  const PairRow<kAxis> row(stage, work, y, z);
  const RowMask open = open_pairs(stage, work, y, z);
  for (int x = 0; x < stage.pairs.x; x += kHalfLanes) {
    if (!is_any_from(open, x)) {
      row.repeat_means(x);
      continue;
    }
    const SignedHalves residual = hn::LoadU(kSignedHalves, residuals + x);
    row.keep_magnitudes(x, residual);
    const SignedHalves detail =
        details_of(kSignedHalves, residual, row.prediction(x), row.limit(x));
    row.keep_excess(x, detail);
    row.put_samples(x, hn::Add(detail, row.known(x)));
  }
}

/// The details in work.residuals to residuals, samples and magnitudes.
template <int kAxis>
void predict_row(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y,
                 std::int64_t z) {
  const PairRow<kAxis> row(stage, work, y, z);
  std::int32_t* const details = work.residuals.row(y, z);
  alignas(64) std::int16_t residuals[kHalfLanes];
  for (int x = 0; x < stage.pairs.x; x += kHalfLanes) {
    const SignedHalves given = hn::Sub(load_narrowed(details + x), row.known(x));
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
  if (stage.first_weighted(y, z) >= stage.pairs.x) return;
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
    const auto count = static_cast<int>(stage_.pairs.x);
    while (last_ < stage_.pairs.y && coded_ + count <= kMaxUnchecked) count_row(last_++);
    is_all_coded_ = coded_ == count * row_count();
    TokenRows rows{counts_, row_count(), contexts_, tokens_};
    if (is_all_coded_ && count % kChunk == 0) {
      // They stand side by side already.
      rows.contexts = work_.contexts.row(first_, z_);
      const bool is_one_row = count % (static_cast<int>(symbols_.state_mask) + 1) == 0;
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
    alignas(64) std::int16_t spread[kBrickSide + 2 * kHalfLanes] = {};
    for (std::int64_t y = first_; y < last_; ++y) {
      if (is_all_coded_) {
        settle_one(found, y);
        found += count;
        continue;
      }
      const RowMask pairs = pairs_[y - first_];
      spread_residuals(pairs, count, found, spread);
      settle_one(spread, y);
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
  void settle_one(const std::int16_t* residuals, std::int64_t y) {
    settle_row<kAxis>(stage_, work_, residuals, y, z_);
    settle_weighted_row(stage_, work_, y, z_, residuals);
    fill_margins(work_.magnitudes[kAxis].row(y, z_), stage_.pairs.x);
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

/// The same of two parts, whose streams do not wait for each other.
template <int kAxis>
void decode_two_planes(const Parameters& p, const SplitTask<std::int16_t>& first,
                       const SplitTask<std::int16_t>& second, std::int64_t z) {
  PlaneDecoder<kAxis> a(p, first, z);
  PlaneDecoder<kAxis> b(p, second, z);
  while (true) {
    const TokenRows of_a = a.gather();
    const TokenRows of_b = b.gather();
    if (of_a.row_count == 0 && of_b.row_count == 0) return;
    const auto has_big = take_token_rows(a.symbols(), of_a, b.symbols(), of_b);
    if (of_a.row_count > 0) a.settle(has_big[0]);
    if (of_b.row_count > 0) b.settle(has_big[1]);
  }
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
