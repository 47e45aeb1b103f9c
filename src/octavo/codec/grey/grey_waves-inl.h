// Prediction from neighbors, vectorized: four or eight rows of pairs at a time, in as many planes,
// each two rows behind the plane before it (see grey_stage.h). A sample waits for the one to its
// left; rows that do not wait for each other keep the machine busy.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_WAVES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_WAVES_INL_H
#undef OCTAVO_CODEC_GREY_WAVES_INL_H
#else
#define OCTAVO_CODEC_GREY_WAVES_INL_H
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

inline constexpr int kLag = 2;  ///< rows between neighboring planes

constexpr hn::FixedTag<std::int16_t, 8> kTaps{};
constexpr hn::FixedTag<std::int32_t, 4> kQuad{};
constexpr hn::CappedTag<std::int16_t, 16> kTapRows{};
/// A number for each row on its way; the partial sums of a row are as many.
constexpr hn::CappedTag<std::int32_t, 8> kWave{};
using Taps = hn::Vec<decltype(kTaps)>;
using Quad = hn::Vec<decltype(kQuad)>;
using Wave = hn::Vec<decltype(kWave)>;
inline constexpr int kWaves = static_cast<int>(hn::MaxLanes(kWave));
inline constexpr int kQuads = kWaves / 4;

/// A row of pairs on its way.
struct WaveRow {
  std::int16_t* at = nullptr;  ///< first sample of the first pair
  const std::int16_t* means = nullptr;
  const std::uint8_t* activities = nullptr;
  const std::uint16_t* limits = nullptr;
  std::int32_t* residuals = nullptr;
  const std::int32_t* edges = nullptr;  ///< details of its edges, 0 for other pairs
  std::int64_t first_weighted = kBrickSide;
};

/// The taps around the samples of one row.
///
/// The last 8 samples written to the row (and to its partner row) are kept in registers: loading
/// them back so soon after narrow stores would stall.
template <int kAxis>
class Chain {
 public:
  HWY_INLINE explicit Chain(const std::int16_t* first)
      : written_(hn::LoadU(kTaps, first - 8)),
        written_partner_(hn::LoadU(kTaps, first + kPartner - 8)) {}
  HWY_INLINE Chain(Taps written, Taps written_partner)
      : written_(written), written_partner_(written_partner) {}

  /// Partial sums of weight times tap.
  HWY_INLINE Wave sums(const std::int16_t* at, const std::int16_t* weights) const {
    auto even = hn::Zero(kWave);
    auto odd = hn::Zero(kWave);
    auto unused = hn::Zero(kWave);
#if HWY_MAX_BYTES >= 32
#pragma GCC unroll 6
    for (int r = 0; r < kRows; r += 4) {
      even =
          hn::ReorderWidenMulAccumulate(kWave, hn::Combine(kTapRows, taps(at, r + 1), taps(at, r)),
                                        hn::LoadU(kTapRows, weights + 8 * r), even, unused);
      if (r + 2 < kRows) {
        odd = hn::ReorderWidenMulAccumulate(
            kWave, hn::Combine(kTapRows, taps(at, r + 3), taps(at, r + 2)),
            hn::LoadU(kTapRows, weights + 8 * r + 16), odd, unused);
      }
    }
#else
#pragma GCC unroll 6
    for (int r = 0; r < kRows; r += 2) {
      even = hn::ReorderWidenMulAccumulate(kWave, taps(at, r), hn::LoadU(kTaps, weights + 8 * r),
                                           even, unused);
      odd = hn::ReorderWidenMulAccumulate(
          kWave, taps(at, r + 1), hn::LoadU(kTaps, weights + 8 * r + 8), odd, unused);
    }
#endif
    return hn::Add(hn::Add(even, odd), unused);
  }

  /// Notes pair number kLane of the four: `a` and `b` hold its samples, `both` a | b << 16.
  template <int kLane>
  HWY_INLINE void advance(Quad a, Quad b, Quad both) {
    if constexpr (kAxis == 0) {
      written_ = hn::CombineShiftRightBytes<4>(kTaps, in_taps<kLane>(both), written_);
    } else {
      written_ = hn::CombineShiftRightBytes<2>(kTaps, in_taps<kLane>(a), written_);
      written_partner_ = hn::CombineShiftRightBytes<2>(kTaps, in_taps<kLane>(b), written_partner_);
    }
  }

 private:
  static constexpr int kRows = TapRows<std::int16_t>::kCount[kAxis];
  static constexpr std::int64_t kPartner = kAxis == 0 ? 0 : pair_step<std::int16_t>(kAxis);
  static constexpr int kOwnRow = kAxis == 0 ? 0 : center_tap(kAxis) / 8;
  static constexpr int kPartnerRow = kAxis == 0 ? -1 : kAxis == 1 ? 3 : 8;

  template <int kLane>
  static HWY_INLINE Taps in_taps(Quad v) {
    return hn::BitCast(kTaps, hn::Broadcast<kLane>(v));
  }

  HWY_INLINE Taps taps(const std::int16_t* at, int r) const {
    if constexpr (kAxis == 0) {
      if (r == kOwnRow) return written_;
    } else {
      // Of a row at -3 the first three samples are written already, the other five still means.
      if (r == kOwnRow)
        return hn::CombineShiftRightBytes<10>(kTaps, hn::LoadU(kTaps, at), written_);
      // The partner row repeats the same means.
      if (r == kPartnerRow) {
        return hn::CombineShiftRightBytes<10>(kTaps, hn::LoadU(kTaps, at), written_partner_);
      }
    }
    return hn::LoadU(kTaps, at + TapRows<std::int16_t>::kOffsets[kAxis][r]);
  }

  Taps written_;
  Taps written_partner_;
};

/// Four numbers of eight.
template <int kHalf>
HWY_INLINE Quad four_of_all(Wave v) {
#if HWY_MAX_BYTES >= 32
  if constexpr (kHalf == 1) return hn::UpperHalf(kQuad, v);
  else return hn::LowerHalf(kQuad, v);
#else
  return v;
#endif
}

/// Sums each of four vectors, or of each half of them: lane k of the result, or of its half, is the
/// sum of the lanes of the k-th.
HWY_INLINE Wave sum_halves(Wave v0, Wave v1, Wave v2, Wave v3) {
  const Wave even = hn::Add(hn::InterleaveLower(kWave, v0, v2), hn::InterleaveUpper(kWave, v0, v2));
  const Wave odd = hn::Add(hn::InterleaveLower(kWave, v1, v3), hn::InterleaveUpper(kWave, v1, v3));
  return hn::Add(hn::InterleaveLower(kWave, even, odd), hn::InterleaveUpper(kWave, even, odd));
}
HWY_INLINE Quad sum_each(Wave v0, Wave v1, Wave v2, Wave v3) {
  const Wave sums = sum_halves(v0, v1, v2, v3);
  if constexpr (kQuads == 1) return four_of_all<0>(sums);
  else return hn::Add(four_of_all<0>(sums), four_of_all<1>(sums));
}

/// What the rows on their way need or give, pair by pair: by fours of them.
struct WaveBuffers {
  static constexpr int kLength = 4 * (static_cast<int>(kBrickSide) + 8);
  using Numbers = std::int32_t[kQuads][kLength];
  alignas(64) Numbers limits;
  alignas(64) Numbers edges;
  alignas(64) Numbers residuals;
  alignas(64) Numbers means;
  // Where values have gaps: details, their highest number, and the number that a residual has
  // beyond the nearer end
  const ValueGaps::Details* details[kQuads][kLength];
  alignas(64) Numbers last;
  alignas(64) Numbers beyond;

  /// Those of the pairs number x.
  static HWY_INLINE Wave load(const Numbers& numbers, int x) {
#if HWY_MAX_BYTES >= 32
    return hn::Combine(kWave, hn::Load(kQuad, numbers[1] + 4 * x),
                       hn::Load(kQuad, numbers[0] + 4 * x));
#else
    return hn::Load(kQuad, numbers[0] + 4 * x);
#endif
  }
  static HWY_INLINE void store(Wave v, Numbers& numbers, int x) {
    hn::Store(four_of_all<0>(v), kQuad, numbers[0] + 4 * x);
    if constexpr (kQuads > 1) hn::Store(four_of_all<1>(v), kQuad, numbers[kQuads - 1] + 4 * x);
  }
};

/// What is between `first` and `last` of four rows, the fours number `four`; both are multiples of
/// 4.
inline void weave(const WaveRow* rows, int first, int last, WaveBuffers& woven, int four) {
  const hn::Rebind<std::int16_t, decltype(kQuad)> short_quad;
  const auto load = [](const std::int32_t* from) { return hn::LoadU(kQuad, from); };
  const auto widen = [&](const std::int16_t* from) HWY_ATTR {
    return hn::PromoteTo(kQuad, hn::LoadU(short_quad, from));
  };
  const hn::Rebind<std::uint16_t, decltype(kQuad)> unsigned_quad;
  const auto limit = [&](const std::uint16_t* from) HWY_ATTR {
    return hn::PromoteTo(kQuad, hn::LoadU(unsigned_quad, from));
  };
  for (int x = first; x < last; x += 4) {
    hn::StoreInterleaved4(limit(rows[0].limits + x), limit(rows[1].limits + x),
                          limit(rows[2].limits + x), limit(rows[3].limits + x), kQuad,
                          woven.limits[four] + 4 * x);
    hn::StoreInterleaved4(load(rows[0].edges + x), load(rows[1].edges + x),
                          load(rows[2].edges + x), load(rows[3].edges + x), kQuad,
                          woven.edges[four] + 4 * x);
    hn::StoreInterleaved4(load(rows[0].residuals + x), load(rows[1].residuals + x),
                          load(rows[2].residuals + x), load(rows[3].residuals + x), kQuad,
                          woven.residuals[four] + 4 * x);
    hn::StoreInterleaved4(widen(rows[0].means + x), widen(rows[1].means + x),
                          widen(rows[2].means + x), widen(rows[3].means + x), kQuad,
                          woven.means[four] + 4 * x);
  }
}

/// The details that the means allow where values have gaps. Residuals are brought to where numbers
/// of details end for certain.
inline void weave_gaps(const ValueGaps& gaps, int first, int last, WaveBuffers& woven, int four) {
  const Quad most = hn::Set(kQuad, 2 * ValueGaps::kReach);
  std::int32_t* const residuals = woven.residuals[four];
  std::int32_t* const highest = woven.last[four];
  for (int at = 4 * first; at < 4 * last; at += 4) {
    for (int k = at; k < at + 4; ++k) {
      woven.details[four][k] = &gaps.of(woven.means[four][k]);
      highest[k] = woven.details[four][k]->last;
    }
    const Quad residual = brought_within(hn::Load(kQuad, residuals + at), most);
    hn::Store(residual, kQuad, residuals + at);
    const Quad left = hn::Add(hn::ShiftLeft<1>(hn::Abs(residual)), hn::BroadcastSignBit(residual));
    const Quad beyond = hn::Sub(hn::Load(kQuad, highest + at), left);
    hn::Store(hn::Max(beyond, hn::Zero(kQuad)), kQuad, woven.beyond[four] + at);
  }
}

/// A number of 16 bits for each of four pairs; a narrow store before a wide load would stall.
template <class NumberOf>
HWY_INLINE Quad four_of(NumberOf&& number_of) {
  std::uint64_t all = 0;
  for (int k = 0; k < 4; ++k) {
    all |= std::uint64_t{static_cast<std::uint16_t>(number_of(k))} << 16 * k;
  }
  const hn::FixedTag<std::int16_t, 4> shorts;
  return hn::PromoteTo(kQuad,
                       hn::BitCast(shorts, hn::Set(hn::FixedTag<std::uint64_t, 1>(), all)));
}

/// Of four pairs where values have gaps: predictions and residuals to details.
HWY_INLINE Quad four_through_gaps(const WaveBuffers& woven, int four, int at, Quad prediction,
                                  Quad residual) {
  const ValueGaps::Details* const* const details = woven.details[four] + at;
  const Quad reach = hn::Set(kQuad, ValueGaps::kReach);
  alignas(16) std::int32_t places[4];
  hn::Store(hn::Add(brought_within(prediction, reach), reach), kQuad, places);
  const Quad nearest = four_of([&](int k) { return details[k]->numbers[places[k]]; });
  // unfolded
  const Quad last = hn::Load(kQuad, woven.last[four] + at);
  const Quad other = hn::Sub(last, nearest);
  const auto is_low = hn::Lt(nearest, other);
  const Quad inside = hn::Add(hn::Max(nearest, other), residual);
  const auto is_beyond = hn::Gt(hn::Abs(residual), hn::Min(nearest, other));
  const Quad number =
      hn::IfThenElse(is_beyond, hn::Load(kQuad, woven.beyond[four] + at), inside);
  hn::Store(hn::IfThenElse(is_low, hn::Sub(last, number), number), kQuad, places);
  return four_of([&](int k) { return details[k]->values[places[k]]; });
}

/// Predictions and details to residuals.
HWY_INLINE Quad four_into_gaps(const WaveBuffers& woven, int four, int at, Quad prediction,
                               Quad detail) {
  alignas(16) std::int32_t predictions[4];
  alignas(16) std::int32_t given[4];
  hn::Store(prediction, kQuad, predictions);
  hn::Store(detail, kQuad, given);
  return four_of([&](int k) {
    const ValueGaps::Details& possible = *woven.details[four][at + k];
    return folded(possible.nearest(given[k]), possible.nearest(predictions[k]), possible.last);
  });
}

/// The same of all pairs number x of some fours, 0 of the others.
template <bool kIsEncoding>
HWY_INLINE Wave wave_through_gaps(const WaveBuffers& woven, unsigned fours, int x, Wave prediction,
                                  Wave given) {
  const auto four = [&](int k, Quad expected, Quad number) HWY_ATTR {
    if ((fours >> k & 1) == 0) return hn::Zero(kQuad);
    if constexpr (kIsEncoding) return four_into_gaps(woven, k, 4 * x, expected, number);
    else return four_through_gaps(woven, k, 4 * x, expected, number);
  };
  const Quad lower = four(0, four_of_all<0>(prediction), four_of_all<0>(given));
#if HWY_MAX_BYTES >= 32
  return hn::Combine(kWave, four(1, four_of_all<1>(prediction), four_of_all<1>(given)), lower);
#else
  return lower;
#endif
}

template <int kAxis>
HWY_INLINE void store_pair(std::int16_t* at, std::int32_t both) {
  if constexpr (kAxis == 0) {
    std::memcpy(at, &both, 4);
  } else {
    at[0] = static_cast<std::int16_t>(both);
    at[pair_step<std::int16_t>(kAxis)] = static_cast<std::int16_t>(both >> 16);
  }
}

/// The samples of the pairs of two weights among the pairs number `x` of the rows.
HWY_NOINLINE void weigh_pairs(const Stage& stage, const WaveRow* rows, int x, Wave mean,
                              Wave detail, Wave& a, Wave& b) {
  alignas(64) std::int32_t means[kWaves], details[kWaves], first[kWaves], second[kWaves];
  hn::Store(mean, kWave, means);
  hn::Store(detail, kWave, details);
  hn::Store(a, kWave, first);
  hn::Store(b, kWave, second);
  for (int k = 0; k < kWaves; ++k) {
    if (x < rows[k].first_weighted) continue;
    const auto pair = weighted_pair<std::int16_t>(stage, means[k], details[k]);
    first[k] = pair.a;
    second[k] = pair.b;
  }
  a = hn::Load(kWave, first);
  b = hn::Load(kWave, second);
}

/// Four of the rows in step.
template <int kAxis>
class FourChains {
 public:
  HWY_INLINE FourChains(const WaveRow* rows, std::int64_t start)
      : rows_(rows),
        c0_(rows[0].at + start),
        c1_(rows[1].at + start),
        c2_(rows[2].at + start),
        c3_(rows[3].at + start) {}

  /// sum_halves of pair number x.
  HWY_INLINE Wave sums(const std::int16_t* weights, int x) const {
    return sum_halves(c0_.sums(at(0, x), weights_of(weights, 0, x)),
                      c1_.sums(at(1, x), weights_of(weights, 1, x)),
                      c2_.sums(at(2, x), weights_of(weights, 2, x)),
                      c3_.sums(at(3, x), weights_of(weights, 3, x)));
  }

  /// a, b  the samples of pair number x; both: a | b << 16
  HWY_INLINE void put(int x, Quad a, Quad b, Quad both) {
    c0_.template advance<0>(a, b, both);
    c1_.template advance<1>(a, b, both);
    c2_.template advance<2>(a, b, both);
    c3_.template advance<3>(a, b, both);
    store_pair<kAxis>(at(0, x), hn::ExtractLane(both, 0));
    store_pair<kAxis>(at(1, x), hn::ExtractLane(both, 1));
    store_pair<kAxis>(at(2, x), hn::ExtractLane(both, 2));
    store_pair<kAxis>(at(3, x), hn::ExtractLane(both, 3));
  }

 private:
  HWY_INLINE std::int16_t* at(int row, int x) const {
    return rows_[row].at + pair_stretch(kAxis) * x;
  }
  /// weights: those of class 0; the others follow.
  HWY_INLINE const std::int16_t* weights_of(const std::int16_t* weights, int row, int x) const {
    return weights + rows_[row].activities[x] * kMaxTaps;
  }

  const WaveRow* rows_;
  Chain<kAxis> c0_, c1_, c2_, c3_;
};

/// All of the rows in step.
template <int kAxis>
class WaveChains {
 public:
  HWY_INLINE WaveChains(const WaveRow* rows, std::int64_t start)
      : first_(rows, start), last_(rows + 4 * (kQuads - 1), start) {}

  /// Weight times tap, summed up, of pair number x of each row of some fours, 0 of the others.
  HWY_INLINE Wave sums(const std::int16_t* weights, int x, unsigned fours) const {
    const Wave first = (fours & 1) != 0 ? first_.sums(weights, x) : hn::Zero(kWave);
#if HWY_MAX_BYTES >= 32
    const Wave last = (fours & 2) != 0 ? last_.sums(weights, x) : hn::Zero(kWave);
    return hn::Add(hn::ConcatLowerLower(kWave, last, first),
                   hn::ConcatUpperUpper(kWave, last, first));
#else
    return first;
#endif
  }
  /// The samples of all of them, or of the first four.
  HWY_INLINE void put(int x, Wave a, Wave b, Wave both, unsigned fours) {
    first_.put(x, four_of_all<0>(a), four_of_all<0>(b), four_of_all<0>(both));
    if (kQuads > 1 && (fours & 2) != 0) {
      last_.put(x, four_of_all<kQuads - 1>(a), four_of_all<kQuads - 1>(b),
                four_of_all<kQuads - 1>(both));
    }
  }

 private:
  FourChains<kAxis> first_;
  FourChains<kAxis> last_;
};

/// A bit for each four of which a pair has a limit.
HWY_INLINE unsigned fours_with_room(Wave limit) {
  const auto has_room = [](Quad limits) HWY_ATTR {
    return hn::AllTrue(kQuad, hn::Eq(limits, hn::Zero(kQuad))) ? 0u : 1u;
  };
  const unsigned first = has_room(four_of_all<0>(limit));
  if constexpr (kQuads == 1) return first;
  else return first | has_room(four_of_all<kQuads - 1>(limit)) << 1;
}

/// The pairs of a row that have a limit.
inline RowMask pairs_with_limits(const std::uint16_t* limits, int count) {
  RowMask pairs = 0;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kHalves));
  for (int x = 0; x < count; x += kLanes) {
    const auto has_limit = hn::Ne(hn::LoadU(kHalves, limits + x), hn::Zero(kHalves));
    pairs |= bits_of(has_limit) << x;
  }
  return pairs & first_pairs(count);
}

/// From the first to the last pair of a row whose detail may differ from 0; widened to multiples
/// of 4.
struct WaveSpan {
  int first = static_cast<int>(kBrickSide);
  int last = 0;

  void add(RowMask pairs) {
    if (pairs == 0) return;
    first = std::min(first, std::countr_zero(pairs) & ~3);
    last = std::max(last, (64 - std::countl_zero(pairs) + 3) & ~3);
  }
};

/// Rows in step, of which the first `count` are no idle ones. weights: those of class 0; the others
/// follow.
template <int kAxis, bool kIsEncoding, bool kHasGaps>
void run_waves(const std::int16_t* weights, const Stage& stage, const WaveRow* rows, int count,
               const WaveSpan& span, WaveBuffers& woven) {
  const int end = std::min(span.last, static_cast<int>(stage.pairs.x));
  std::int64_t first_weighted = end;
  for (int k = 0; k < kWaves; ++k) {
    first_weighted = std::min(first_weighted, rows[k].first_weighted);
  }
  const ResidualMap<decltype(kWave)> map(stage.step);
  for (int four = 0; 4 * four < count; ++four) {
    weave(rows + 4 * four, span.first, span.last, woven, four);
    if constexpr (kHasGaps) weave_gaps(*stage.gaps, span.first, span.last, woven, four);
  }
  const unsigned fours = count > 4 ? 3 : 1;
  WaveChains<kAxis> chains(rows, pair_stretch(kAxis) * span.first);
  const Wave half = hn::Set(kWave, 1 << (kWeightBits - 1));
  const Wave round = hn::Set(kWave, stage.rounding);
  const Wave one = hn::Set(kWave, 1);
  const Wave low_half = hn::Set(kWave, 0xffff);
  for (int x = span.first; x < end; ++x) {
    // Predict a sample of each row; without room, as an edge or a uniform cell, it is known.
    const Wave limit = WaveBuffers::load(woven.limits, x);
    const Wave known = WaveBuffers::load(woven.edges, x);
    const unsigned rooms = fours_with_room(limit) & fours;
    const Wave sum = chains.sums(weights, x, rooms);
    const Wave mean = WaveBuffers::load(woven.means, x);
    const Wave prediction = hn::ShiftRight<kWeightBits>(hn::Add(sum, half));
    // Detail to residual, or residual to detail, counted from those of edges
    Wave detail = WaveBuffers::load(woven.residuals, x);
    if constexpr (kHasGaps) {
      const Wave expected = hn::Add(known, brought_within(prediction, limit));
      const Wave found = wave_through_gaps<kIsEncoding>(woven, kIsEncoding ? fours : rooms, x,
                                                        expected, detail);
      if constexpr (kIsEncoding) WaveBuffers::store(found, woven.residuals, x);
      else detail = found;
      detail = brought_within(hn::Sub(detail, known), limit);
    } else if constexpr (kIsEncoding) {
      detail = hn::Sub(detail, known);
      WaveBuffers::store(map.residual(detail, prediction, limit), woven.residuals, x);
    } else {
      detail = map.detail(detail, prediction, limit);
    }
    detail = hn::Add(detail, known);
    // Mean and detail to the two samples, which the next predictions see
    const Wave total = hn::Add(hn::Sub(hn::Add(mean, mean), round),
                               hn::And(hn::Add(detail, round), one));
    Wave a = hn::ShiftRight<1>(hn::Add(total, detail));
    Wave b = hn::ShiftRight<1>(hn::Sub(total, detail));
    if (x >= first_weighted) weigh_pairs(stage, rows, x, mean, detail, a, b);
    chains.put(x, a, b, hn::Or(hn::And(a, low_half), hn::ShiftLeft<16>(b)), fours);
  }
  if constexpr (kIsEncoding) {
    for (int row = 0; row < count; ++row) {
      std::int32_t* const residuals = rows[row].residuals;
      std::fill(residuals, residuals + span.first, 0);
      for (int x = span.first; x < end; ++x) {
        residuals[x] = woven.residuals[row / 4][4 * x + row % 4];
      }
      std::fill(residuals + end, residuals + stage.pairs.x, 0);
    }
  }
}

/// A row that stands in where fewer are on their way.
struct IdleRow {
  std::vector<std::int16_t> samples =
      std::vector<std::int16_t>(static_cast<std::size_t>(5 * SampleGrid<std::int16_t>::kPlane));
  std::uint16_t limits[kBrickSide + 16] = {};
  std::int32_t residuals[kBrickSide + 16] = {};
  std::int32_t edges[kBrickSide + 16] = {};
  std::uint8_t activities[kBrickSide + 16] = {};

  WaveRow row() {
    std::int16_t* const middle = samples.data() + samples.size() / 2;
    return {middle, middle, activities, limits, residuals, edges, kBrickSide};
  }
};

/// First tick of every plane: two rows behind the plane before it, and after the plane that its
/// wave does first.
inline std::array<std::int64_t, kBrickSide> wave_starts(const Size3& pairs) {
  std::array<std::int64_t, kBrickSide> starts{};
  for (std::int64_t z = 1; z < pairs.z; ++z) {
    const auto at = static_cast<std::size_t>(z);
    starts[at] = starts[at - 1] + kLag;
    if (z >= kWaves) starts[at] = std::max(starts[at], starts[at - kWaves] + pairs.y);
  }
  return starts;
}

template <int kAxis, bool kIsEncoding>
void reconstruct_waves(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work) {
  static thread_local IdleRow idle;
  static thread_local WaveBuffers woven;
  const Size3& pairs = stage.pairs;
  const auto starts = wave_starts(pairs);
  const std::int64_t end = starts[static_cast<std::size_t>(pairs.z) - 1] + pairs.y;
  std::int64_t plane[kWaves];
  for (int wave = 0; wave < kWaves; ++wave) plane[wave] = wave;
  for (std::int64_t tick = 0; tick < end; ++tick) {
    WaveRow rows[kWaves];
    int count = 0;
    WaveSpan span;
    for (std::int64_t& z : plane) {
      if (z >= pairs.z || tick < starts[static_cast<std::size_t>(z)]) continue;
      const std::int64_t at_z = z;
      const std::int64_t y = tick - starts[static_cast<std::size_t>(z)];
      if (y + 1 == pairs.y) z += kWaves;
      const std::uint16_t* const limits = work.limits.row(y, at_z);
      const std::int32_t* const edges = edge_details(stage, work, y, at_z);
      RowMask moving = pairs_with_limits(limits, static_cast<int>(pairs.x));
      if (edges != nullptr) moving |= work.edges.row(y, at_z);
      if (moving == 0) {
        if constexpr (kIsEncoding) std::fill_n(work.residuals.row(y, at_z), pairs.x, 0);
        continue;
      }
      span.add(moving);
      rows[count++] = {first_of_row(work.fine, kAxis, y, at_z),
                       work.means.row(y, at_z),
                       work.activities.row(y, at_z),
                       limits,
                       work.residuals.row(y, at_z),
                       edges != nullptr ? edges : idle.edges,
                       stage.first_weighted(y, at_z)};
    }
    if (count == 0) continue;
    std::fill(rows + count, rows + kWaves, idle.row());
    const std::int16_t* const weights = p.weights[stage.group][kAxis][0];
    if (stage.gaps != nullptr) {
      run_waves<kAxis, kIsEncoding, true>(weights, stage, rows, count, span, woven);
    } else {
      run_waves<kAxis, kIsEncoding, false>(weights, stage, rows, count, span, woven);
    }
  }
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
