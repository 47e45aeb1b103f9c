// Prediction from neighbors of details that are kept exactly, vectorized: an encoder knows the
// samples beforehand, so that no pair of a row waits for another.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_EXACT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_EXACT_INL_H
#undef OCTAVO_CODEC_GREY_EXACT_INL_H
#else
#define OCTAVO_CODEC_GREY_EXACT_INL_H
#endif

#include <hwy/highway.h>

#include "octavo/codec/grey/grey_waves-inl.h"

// Places within a row are small numbers.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

/// The samples of a row of pairs, as a decoder will have them, behind the 8 before the row.
template <int kAxis>
class ExactRow {
 public:
  /// Makes them of the details in work.residuals.
  ExactRow(const Stage& stage, Workspace<std::int16_t>& work, std::int64_t y, std::int64_t z)
      : count_(static_cast<int>(stage.pairs.x)), to_(first_of_row(work.fine, kAxis, y, z)) {
    std::memcpy(first_, to_ - kBefore, kBefore * sizeof(std::int16_t));
    if constexpr (kAxis != 0) {
      std::memcpy(second_, to_ + kPartner - kBefore, kBefore * sizeof(std::int16_t));
    }
    const std::int16_t* const means = work.means.row(y, z);
    const std::int32_t* const details = work.residuals.row(y, z);
    const std::uint16_t* const limits = work.limits.row(y, z);
    const std::int32_t* const edges = edge_details(stage, work, y, z);
    const Octet round = hn::Set(kOctet, stage.rounding);
    const Octet one = hn::Set(kOctet, 1);
    for (int x = 0; x < count_; x += kLanes) {
      const Octet mean = hn::PromoteTo(kOctet, hn::LoadU(kShortOctet, means + x));
      const Octet detail = within(details, limits, edges, x);
      const Octet total = hn::Add(hn::Sub(hn::Add(mean, mean), round),
                                  hn::And(hn::Add(detail, round), one));
      put(x, hn::ShiftRight<1>(hn::Add(total, detail)), hn::ShiftRight<1>(hn::Sub(total, detail)));
    }
    for (std::int64_t x = stage.first_weighted(y, z); x < count_; ++x) {
      const std::int32_t known = edges != nullptr ? edges[x] : 0;
      const std::int32_t limit = limits[x];
      const auto pair = weighted_pair<std::int16_t>(
          stage, means[x], std::clamp(details[x] - known, -limit, limit) + known);
      std::int16_t* const at = first_ + kBefore + kStretch * x;
      at[0] = pair.a;
      (kAxis == 0 ? at[1] : second_[kBefore + x]) = pair.b;
    }
  }

  /// The taps around pair x.
  HWY_INLINE Chain<kAxis> chain(int x) const {
    return Chain<kAxis>(hn::LoadU(kTaps, first_ + kStretch * x),
                        hn::LoadU(kTaps, kAxis == 0 ? first_ : second_ + x));
  }

  /// Writes the samples to the fine grid.
  void store() const {
    const auto bytes = static_cast<std::size_t>(count_) * sizeof(std::int16_t);
    std::memcpy(to_, first_ + kBefore, kStretch * bytes);
    if constexpr (kAxis != 0) std::memcpy(to_ + kPartner, second_ + kBefore, bytes);
  }

 private:
  static constexpr hn::CappedTag<std::int32_t, 8> kOctet{};
  static constexpr hn::Rebind<std::int16_t, decltype(kOctet)> kShortOctet{};
  static constexpr hn::Rebind<std::uint16_t, decltype(kOctet)> kLimitOctet{};
  using Octet = hn::Vec<decltype(kOctet)>;
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(kOctet));
  static constexpr int kBefore = 8;
  static constexpr int kStretch = static_cast<int>(pair_stretch(kAxis));
  static constexpr std::int64_t kPartner = pair_step<std::int16_t>(kAxis);
  static constexpr int kLength = kBefore + static_cast<int>(kBrickSide) + 16;

  /// Details within their limits, counted from those of edges.
  static HWY_INLINE Octet within(const std::int32_t* details, const std::uint16_t* limits,
                                 const std::int32_t* edges, int x) {
    const Octet limit = hn::PromoteTo(kOctet, hn::LoadU(kLimitOctet, limits + x));
    const Octet known = edges != nullptr ? hn::LoadU(kOctet, edges + x) : hn::Zero(kOctet);
    const Octet detail = hn::Sub(hn::LoadU(kOctet, details + x), known);
    return hn::Add(brought_within(detail, limit), known);
  }
  HWY_INLINE void put(int x, Octet a, Octet b) {
    if constexpr (kAxis == 0) {
      const Octet both = hn::Or(hn::And(a, hn::Set(kOctet, 0xffff)), hn::ShiftLeft<16>(b));
      const hn::Repartition<std::int16_t, decltype(kOctet)> samples;
      hn::StoreU(hn::BitCast(samples, both), samples, first_ + kBefore + 2 * x);
    } else {
      hn::StoreU(hn::DemoteTo(kShortOctet, a), kShortOctet, first_ + kBefore + x);
      hn::StoreU(hn::DemoteTo(kShortOctet, b), kShortOctet, second_ + kBefore + x);
    }
  }

  int count_;
  std::int16_t* to_;
  alignas(64) std::int16_t first_[kLength];   ///< of all pairs of an axis of 0
  alignas(64) std::int16_t second_[kLength];  ///< those beside them along another axis
};

/// Turns the details of a row into residuals and completes its samples. The rows before it hold
/// their samples, those ahead the means.
template <int kAxis>
void predict_exact_row(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
                       std::int64_t y, std::int64_t z) {
  const ExactRow<kAxis> row(stage, work, y, z);
  const std::int16_t* const at = first_of_row(work.fine, kAxis, y, z);
  const std::int16_t* const means = work.means.row(y, z);
  const std::uint8_t* const activities = work.activities.row(y, z);
  const std::uint16_t* const limits = work.limits.row(y, z);
  const std::int32_t* const edges = edge_details(stage, work, y, z);
  std::int32_t* const residuals = work.residuals.row(y, z);
  const std::int16_t* const weights = p.weights[stage.group][kAxis][0];
  const hn::Rebind<std::uint16_t, decltype(kQuad)> short_limits;
  const Quad half = hn::Set(kQuad, 1 << (kWeightBits - 1));
  const auto sums_of = [&](int x) HWY_ATTR {
    return row.chain(x).sums(at + pair_stretch(kAxis) * x, weights + activities[x] * kMaxTaps);
  };
  for (int x = 0; x < stage.pairs.x; x += 4) {
    const Quad limit = hn::PromoteTo(kQuad, hn::LoadU(short_limits, limits + x));
    const Quad known = edges != nullptr ? hn::LoadU(kQuad, edges + x) : hn::Zero(kQuad);
    Quad prediction = hn::Zero(kQuad);
    if (!hn::AllTrue(kQuad, hn::Eq(limit, hn::Zero(kQuad)))) {
      const Quad sum = sum_each(sums_of(x), sums_of(x + 1), sums_of(x + 2), sums_of(x + 3));
      prediction = hn::ShiftRight<kWeightBits>(hn::Add(sum, half));
    }
    const Quad detail = hn::LoadU(kQuad, residuals + x);
    Quad residual;
    if (stage.gaps != nullptr) {
      const Quad expected = hn::Add(known, brought_within(prediction, limit));
      residual = through_gaps<true>(kQuad, *stage.gaps, means + x, expected, detail);
    } else {
      residual = residuals_of(kQuad, brought_within(hn::Sub(detail, known), limit), prediction,
                              limit);
    }
    hn::StoreU(residual, kQuad, residuals + x);
  }
  row.store();
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
