// Prediction from neighbors, vectorized: four rows of pairs at a time, in four planes, each two
// rows behind the plane before it (see grey_stage.h). A sample waits for the one to its left; four
// rows that do not wait for each other keep the machine busy.
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

inline constexpr int kWaves = 4;
inline constexpr int kLag = 2;  ///< rows between neighboring planes

constexpr hn::FixedTag<std::int16_t, 8> kTaps{};
constexpr hn::FixedTag<std::int32_t, 4> kQuad{};
constexpr hn::CappedTag<std::int16_t, 16> kTapRows{};
using Taps = hn::Vec<decltype(kTaps)>;
using Quad = hn::Vec<decltype(kQuad)>;

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

  /// Four partial sums of weight times tap.
  HWY_INLINE Quad sums(const std::int16_t* at, const std::int16_t* weights) const {
#if HWY_MAX_BYTES >= 32
    const hn::FixedTag<std::int32_t, 8> octet;
    auto even = hn::Zero(octet);
    auto odd = hn::Zero(octet);
    auto unused = hn::Zero(octet);
#pragma GCC unroll 6
    for (int r = 0; r < kRows; r += 4) {
      even =
          hn::ReorderWidenMulAccumulate(octet, hn::Combine(kTapRows, taps(at, r + 1), taps(at, r)),
                                        hn::LoadU(kTapRows, weights + 8 * r), even, unused);
      if (r + 2 < kRows) {
        odd = hn::ReorderWidenMulAccumulate(
            octet, hn::Combine(kTapRows, taps(at, r + 3), taps(at, r + 2)),
            hn::LoadU(kTapRows, weights + 8 * r + 16), odd, unused);
      }
    }
    const auto all = hn::Add(hn::Add(even, odd), unused);
    return hn::Add(hn::LowerHalf(kQuad, all), hn::UpperHalf(kQuad, all));
#else
    auto even = hn::Zero(kQuad);
    auto odd = hn::Zero(kQuad);
    auto unused = hn::Zero(kQuad);
#pragma GCC unroll 6
    for (int r = 0; r < kRows; r += 2) {
      even = hn::ReorderWidenMulAccumulate(kQuad, taps(at, r), hn::LoadU(kTaps, weights + 8 * r),
                                           even, unused);
      odd = hn::ReorderWidenMulAccumulate(
          kQuad, taps(at, r + 1), hn::LoadU(kTaps, weights + 8 * r + 8), odd, unused);
    }
    return hn::Add(hn::Add(even, odd), unused);
#endif
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

/// Sums each of four vectors: lane k of the result is the sum of the lanes of the k-th.
HWY_INLINE Quad sum_each(Quad v0, Quad v1, Quad v2, Quad v3) {
  const Quad even = hn::Add(hn::InterleaveLower(kQuad, v0, v2), hn::InterleaveUpper(kQuad, v0, v2));
  const Quad odd = hn::Add(hn::InterleaveLower(kQuad, v1, v3), hn::InterleaveUpper(kQuad, v1, v3));
  return hn::Add(hn::InterleaveLower(kQuad, even, odd), hn::InterleaveUpper(kQuad, even, odd));
}

/// What four rows need or give, pair by pair.
struct WaveBuffers {
  static constexpr int kLength = kWaves * (static_cast<int>(kBrickSide) + 8);
  alignas(64) std::int32_t limits[kLength];
  alignas(64) std::int32_t edges[kLength];
  alignas(64) std::int32_t residuals[kLength];
  alignas(64) std::int32_t means[kLength];
  // Where values have gaps: details, their highest number, and the number that a residual has
  // beyond the nearer end
  const ValueGaps::Details* details[kLength];
  alignas(64) std::int32_t last[kLength];
  alignas(64) std::int32_t beyond[kLength];
};

/// What is between `first` and `last` of four rows; both are multiples of 4.
inline void weave(const WaveRow* rows, int first, int last, WaveBuffers& woven) {
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
                          woven.limits + 4 * x);
    hn::StoreInterleaved4(load(rows[0].edges + x), load(rows[1].edges + x),
                          load(rows[2].edges + x), load(rows[3].edges + x), kQuad,
                          woven.edges + 4 * x);
    hn::StoreInterleaved4(load(rows[0].residuals + x), load(rows[1].residuals + x),
                          load(rows[2].residuals + x), load(rows[3].residuals + x), kQuad,
                          woven.residuals + 4 * x);
    hn::StoreInterleaved4(widen(rows[0].means + x), widen(rows[1].means + x),
                          widen(rows[2].means + x), widen(rows[3].means + x), kQuad,
                          woven.means + 4 * x);
  }
}

/// The details that the means allow where values have gaps. Residuals are brought to where numbers
/// of details end for certain.
inline void weave_gaps(const ValueGaps& gaps, int first, int last, WaveBuffers& woven) {
  const Quad most = hn::Set(kQuad, 2 * ValueGaps::kReach);
  for (int at = 4 * first; at < 4 * last; at += 4) {
    for (int k = at; k < at + 4; ++k) {
      woven.details[k] = &gaps.of(woven.means[k]);
      woven.last[k] = woven.details[k]->last;
    }
    const Quad residual = brought_within(hn::Load(kQuad, woven.residuals + at), most);
    hn::Store(residual, kQuad, woven.residuals + at);
    const Quad left = hn::Add(hn::ShiftLeft<1>(hn::Abs(residual)), hn::BroadcastSignBit(residual));
    const Quad beyond = hn::Sub(hn::Load(kQuad, woven.last + at), left);
    hn::Store(hn::Max(beyond, hn::Zero(kQuad)), kQuad, woven.beyond + at);
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
HWY_INLINE Quad four_through_gaps(const WaveBuffers& woven, int at, Quad prediction,
                                  Quad residual) {
  const ValueGaps::Details* const* const details = woven.details + at;
  const Quad reach = hn::Set(kQuad, ValueGaps::kReach);
  alignas(16) std::int32_t places[4];
  hn::Store(hn::Add(brought_within(prediction, reach), reach), kQuad, places);
  const Quad nearest = four_of([&](int k) { return details[k]->numbers[places[k]]; });
  // unfolded
  const Quad last = hn::Load(kQuad, woven.last + at);
  const Quad other = hn::Sub(last, nearest);
  const auto is_low = hn::Lt(nearest, other);
  const Quad inside = hn::Add(hn::Max(nearest, other), residual);
  const auto is_beyond = hn::Gt(hn::Abs(residual), hn::Min(nearest, other));
  const Quad number =
      hn::IfThenElse(is_beyond, hn::Load(kQuad, woven.beyond + at), inside);
  hn::Store(hn::IfThenElse(is_low, hn::Sub(last, number), number), kQuad, places);
  return four_of([&](int k) { return details[k]->values[places[k]]; });
}

/// Predictions and details to residuals.
HWY_INLINE Quad four_into_gaps(const WaveBuffers& woven, int at, Quad prediction, Quad detail) {
  alignas(16) std::int32_t predictions[4];
  alignas(16) std::int32_t given[4];
  hn::Store(prediction, kQuad, predictions);
  hn::Store(detail, kQuad, given);
  return four_of([&](int k) {
    const ValueGaps::Details& possible = *woven.details[at + k];
    return folded(possible.nearest(given[k]), possible.nearest(predictions[k]), possible.last);
  });
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

/// The samples of the pairs of two weights among the pairs number `x` of four rows.
HWY_NOINLINE void weigh_pairs(const Stage& stage, const WaveRow* rows, int x, Quad mean,
                              Quad detail, Quad& a, Quad& b) {
  alignas(16) std::int32_t means[kWaves], details[kWaves], first[kWaves], second[kWaves];
  hn::Store(mean, kQuad, means);
  hn::Store(detail, kQuad, details);
  hn::Store(a, kQuad, first);
  hn::Store(b, kQuad, second);
  for (int k = 0; k < kWaves; ++k) {
    if (x < rows[k].first_weighted) continue;
    const auto pair = weighted_pair<std::int16_t>(stage, means[k], details[k]);
    first[k] = pair.a;
    second[k] = pair.b;
  }
  a = hn::Load(kQuad, first);
  b = hn::Load(kQuad, second);
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

/// Four rows in step. weights: those of class 0; the others follow.
template <int kAxis, bool kIsEncoding, bool kHasGaps>
void run_waves(const std::int16_t* weights, const Stage& stage, const WaveRow* rows,
               const WaveSpan& span, WaveBuffers& woven) {
  const int end = std::min(span.last, static_cast<int>(stage.pairs.x));
  std::int64_t first_weighted = end;
  for (int k = 0; k < kWaves; ++k) {
    first_weighted = std::min(first_weighted, rows[k].first_weighted);
  }
  const ResidualMap<decltype(kQuad)> map(stage.step);
  weave(rows, span.first, span.last, woven);
  if constexpr (kHasGaps) weave_gaps(*stage.gaps, span.first, span.last, woven);
  const std::int64_t start = pair_stretch(kAxis) * span.first;
  Chain<kAxis> c0(rows[0].at + start), c1(rows[1].at + start), c2(rows[2].at + start),
      c3(rows[3].at + start);
  const Quad half = hn::Set(kQuad, 1 << (kWeightBits - 1));
  const Quad round = hn::Set(kQuad, stage.rounding);
  const Quad one = hn::Set(kQuad, 1);
  const Quad low_half = hn::Set(kQuad, 0xffff);
  const auto weights_of = [&](const WaveRow& row, int x) {
    return weights + row.activities[x] * kMaxTaps;
  };
  for (int x = span.first; x < end; ++x) {
    const std::int64_t at = pair_stretch(kAxis) * x;
    // Predict a sample of each row; without room, as an edge or a uniform cell, it is known.
    const Quad limit = hn::Load(kQuad, woven.limits + 4 * x);
    const Quad known = hn::Load(kQuad, woven.edges + 4 * x);
    const bool has_room = !hn::AllTrue(kQuad, hn::Eq(limit, hn::Zero(kQuad)));
    Quad sum = hn::Zero(kQuad);
    if (has_room) {
      sum = sum_each(c0.sums(rows[0].at + at, weights_of(rows[0], x)),
                     c1.sums(rows[1].at + at, weights_of(rows[1], x)),
                     c2.sums(rows[2].at + at, weights_of(rows[2], x)),
                     c3.sums(rows[3].at + at, weights_of(rows[3], x)));
    }
    const Quad mean = hn::Load(kQuad, woven.means + 4 * x);
    const Quad prediction = hn::ShiftRight<kWeightBits>(hn::Add(sum, half));
    // Detail to residual, or residual to detail, counted from those of edges
    Quad detail = hn::Load(kQuad, woven.residuals + 4 * x);
    if (!kIsEncoding && !has_room) {
      detail = hn::Zero(kQuad);
    } else if constexpr (kHasGaps) {
      const Quad expected = hn::Add(known, brought_within(prediction, limit));
      if constexpr (kIsEncoding) {
        hn::Store(four_into_gaps(woven, 4 * x, expected, detail), kQuad, woven.residuals + 4 * x);
      } else {
        detail = four_through_gaps(woven, 4 * x, expected, detail);
      }
      detail = brought_within(hn::Sub(detail, known), limit);
    } else if constexpr (kIsEncoding) {
      detail = hn::Sub(detail, known);
      hn::Store(map.residual(detail, prediction, limit), kQuad, woven.residuals + 4 * x);
    } else {
      detail = map.detail(detail, prediction, limit);
    }
    detail = hn::Add(detail, known);
    // Mean and detail to the two samples, which the next predictions see
    const Quad total = hn::Add(hn::Sub(hn::Add(mean, mean), round),
                               hn::And(hn::Add(detail, round), one));
    Quad a = hn::ShiftRight<1>(hn::Add(total, detail));
    Quad b = hn::ShiftRight<1>(hn::Sub(total, detail));
    if (x >= first_weighted) weigh_pairs(stage, rows, x, mean, detail, a, b);
    const Quad both = hn::Or(hn::And(a, low_half), hn::ShiftLeft<16>(b));
    c0.template advance<0>(a, b, both);
    c1.template advance<1>(a, b, both);
    c2.template advance<2>(a, b, both);
    c3.template advance<3>(a, b, both);
    store_pair<kAxis>(rows[0].at + at, hn::ExtractLane(both, 0));
    store_pair<kAxis>(rows[1].at + at, hn::ExtractLane(both, 1));
    store_pair<kAxis>(rows[2].at + at, hn::ExtractLane(both, 2));
    store_pair<kAxis>(rows[3].at + at, hn::ExtractLane(both, 3));
  }
  if constexpr (kIsEncoding) {
    const auto count = static_cast<int>(stage.pairs.x);
    for (int row = 0; row < kWaves; ++row) {
      std::int32_t* const residuals = rows[row].residuals;
      std::fill(residuals, residuals + span.first, 0);
      for (int x = span.first; x < end; ++x) residuals[x] = woven.residuals[4 * x + row];
      std::fill(residuals + end, residuals + count, 0);
    }
  }
}

/// A row that stands in where fewer than four are on their way.
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
    WaveSpan span;
    for (int wave = 0; wave < kWaves; ++wave) {
      rows[wave] = idle.row();
      const std::int64_t z = plane[wave];
      if (z >= pairs.z || tick < starts[static_cast<std::size_t>(z)]) continue;
      const std::int64_t y = tick - starts[static_cast<std::size_t>(z)];
      if (y + 1 == pairs.y) plane[wave] += kWaves;
      const std::uint16_t* const limits = work.limits.row(y, z);
      const std::int32_t* const edges = edge_details(stage, work, y, z);
      RowMask moving = pairs_with_limits(limits, static_cast<int>(pairs.x));
      if (edges != nullptr) moving |= work.edges.row(y, z);
      if (moving == 0) {
        if constexpr (kIsEncoding) std::fill_n(work.residuals.row(y, z), pairs.x, 0);
        continue;
      }
      span.add(moving);
      rows[wave] = {first_of_row(work.fine, kAxis, y, z),
                    work.means.row(y, z),
                    work.activities.row(y, z),
                    limits,
                    work.residuals.row(y, z),
                    edges != nullptr ? edges : idle.edges,
                    stage.first_weighted(y, z)};
    }
    if (span.last == 0) continue;
    const std::int16_t* const weights = p.weights[stage.group][kAxis][0];
    if (stage.gaps != nullptr) {
      run_waves<kAxis, kIsEncoding, true>(weights, stage, rows, span, woven);
    } else {
      run_waves<kAxis, kIsEncoding, false>(weights, stage, rows, span, woven);
    }
  }
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
