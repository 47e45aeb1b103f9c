// The pairs of a row that may be edges, vectorized (edge_candidates.h).
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_EDGES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_EDGES_INL_H
#undef OCTAVO_CODEC_GREY_EDGES_INL_H
#else
#define OCTAVO_CODEC_GREY_EDGES_INL_H
#endif

#include <hwy/highway.h>

#include "octavo/codec/grey/edge_candidates.h"
#include "octavo/codec/grey/grey_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

/// background_of
inline RowMask background_of_row(const std::int16_t* means, int count, std::int16_t lowest) {
  RowMask background = 0;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kHalves));
  for (int x = 0; x < count; x += kLanes) {
    const auto is_lowest =
        hn::Eq(hn::LoadU(kSignedHalves, means + x), hn::Set(kSignedHalves, lowest));
    background |= bits_of(hn::RebindMask(kHalves, is_lowest)) << x;
  }
  return background & first_pairs(count);
}

/// Leaves out the samples that do not occur.
inline void close_gaps(const Stage& stage, const std::int16_t* means, CandidateRow& row) {
  for_each_pair(row.pairs, [&](int x) HWY_ATTR {
    const RowMask bit = RowMask{1} << x;
    const std::int64_t other = 2 * std::int64_t{means[x]} - stage.rounding - stage.min;
    if (!stage.gaps->occurs(other)) row.may_be_even &= ~bit;
    if (!stage.gaps->occurs(other + 1)) row.may_be_odd &= ~bit;
  });
}

/// describe_candidates
inline void describe_row(const Stage& stage, const std::int16_t* means, const EdgeMasks& beside,
                         CandidateRow& row) {
  const auto set = [](std::int64_t value) HWY_ATTR {
    return hn::Set(kHalves, static_cast<std::uint16_t>(value));
  };
  const auto is_at_most = [](Halves a, Halves b) HWY_ATTR { return hn::Eq(hn::Min(a, b), a); };
  const std::int64_t step = pair_step<std::int16_t>(stage.axis);
  const Halves lowest = set(stage.min);
  // The other sample, counted from the background, is twice the mean less `rounding` or one more.
  const std::int64_t range = stage.max - stage.min;
  const Halves most_even = set((range + stage.rounding) >> 1);
  const Halves most_odd = set((range + stage.rounding - 1) >> 1);
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kHalves));
  for (int x = 0; x < stage.pairs.x; x += kLanes) {
    if ((row.pairs >> x & first_pairs(kLanes)) == 0) continue;
    const auto above_lowest = [&](hn::Vec<decltype(kSignedHalves)> samples) HWY_ATTR {
      return hn::Sub(hn::BitCast(kHalves, samples), lowest);
    };
    const Halves mean = above_lowest(hn::LoadU(kSignedHalves, means + x));
    const Halves beyond = above_lowest(hn::Max(hn::LoadU(kSignedHalves, means + x - step),
                                               hn::LoadU(kSignedHalves, means + x + step)));
    Halves context = set(stage.axis == 0 ? 1 : 0);
    // Ratios are reached from `beyond` less the rest of it on, which is rounded down.
    for (const int ratio : kEdgeRatios) {
      const Halves rest = hn::MulHigh(beyond, set((16 - ratio) << 12));
      const auto is_reached = is_at_most(hn::Sub(beyond, rest), mean);
      context = hn::Add(context, hn::IfThenElseZero(is_reached, set(kRatioWeight)));
    }
    const auto add = [&](RowMask pairs, int weight) HWY_ATTR {
      context = hn::Add(context, hn::IfThenElseZero(lanes_of(pairs, x), set(weight)));
    };
    add(beside.along1, kAlongWeight);
    add(beside.along2, 2 * kAlongWeight);
    add(beside.across1, kAcrossWeight);
    add(beside.across2, 2 * kAcrossWeight);
    add(beside.side1, kSideWeight);
    add(beside.side2, 2 * kSideWeight);
    hn::StoreU(context, kHalves, row.contexts + x);
    const RowMask is_high = bits_of(is_at_most(set(kMinEdgeMean), mean));
    row.may_be_even |= (is_high & bits_of(is_at_most(mean, most_even))) << x;
    row.may_be_odd |= (is_high & bits_of(is_at_most(mean, most_odd))) << x;
  }
  row.pairs &= row.may_be_even;
  if (stage.gaps == nullptr) return;
  close_gaps(stage, means, row);
  row.pairs &= row.may_be_even | row.may_be_odd;
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();

#endif
