// The splits of the grey codec for every instruction set that Highway knows, chosen at run time.

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "octavo/codec/grey_portable.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "octavo/codec/grey_stage_simd.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

using portable::Dot;

#else

namespace hn = hwy::HWY_NAMESPACE;

/// The weighted sum of the taps around a sample, 8 taps at a time.
///
/// The last 8 samples written to the current row (and to its partner row) are kept in registers:
/// loading them back so soon after narrow stores would stall.
template <int kAxis, class Sample>
class Dot {
 public:
  explicit Dot(const Sample* first)
      : written_(hn::LoadU(kTaps, first - 8)),
        written_partner_(hn::LoadU(kTaps, first + kPartner - 8)) {}

  HWY_INLINE std::int32_t operator()(const Sample* at, const std::int16_t* weights) const {
    const hn::FixedTag<std::int32_t, 4> sums;
    auto even = hn::Zero(sums);
    auto odd = hn::Zero(sums);
    auto unused = hn::Zero(sums);
    constexpr int kRows = TapRows<Sample>::kCount[kAxis];
    for (int r = 0; r < kRows; r += 2) {
      even = hn::ReorderWidenMulAccumulate(sums, taps(at, r), hn::Load(kTaps, weights + 8 * r),
                                           even, unused);
      odd = hn::ReorderWidenMulAccumulate(sums, taps(at, r + 1),
                                          hn::Load(kTaps, weights + 8 * r + 8), odd, unused);
    }
    return hn::GetLane(hn::SumOfLanes(sums, hn::Add(hn::Add(even, odd), unused)));
  }

  HWY_INLINE void advance(Sample a, Sample b) {
    if constexpr (kAxis == 0) {
      const auto pair = static_cast<std::uint32_t>(static_cast<std::uint16_t>(a)) |
                        static_cast<std::uint32_t>(static_cast<std::uint16_t>(b)) << 16;
      const hn::FixedTag<std::uint32_t, 4> words;
      written_ =
          hn::CombineShiftRightBytes<4>(kTaps, hn::BitCast(kTaps, hn::Set(words, pair)), written_);
    } else {
      written_ = hn::CombineShiftRightBytes<2>(kTaps, hn::Set(kTaps, a), written_);
      written_partner_ = hn::CombineShiftRightBytes<2>(kTaps, hn::Set(kTaps, b), written_partner_);
    }
  }

 private:
  static constexpr hn::FixedTag<std::int16_t, 8> kTaps{};
  using Vector = hn::Vec<hn::FixedTag<std::int16_t, 8>>;
  static constexpr std::int64_t kPartner =
      kAxis == 0 ? 0 : kAxis == 1 ? SampleGrid<Sample>::kRow : SampleGrid<Sample>::kPlane;
  static constexpr int kOwnRow = kAxis == 0 ? 0 : centre_tap(kAxis) / 8;
  static constexpr int kPartnerRow = kAxis == 0 ? -1 : kAxis == 1 ? 3 : 8;

  HWY_INLINE Vector taps(const Sample* at, int r) const {
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
    return hn::LoadU(kTaps, at + TapRows<Sample>::kOffsets[kAxis][r]);
  }

  Vector written_;
  Vector written_partner_;
};

#endif

#include "octavo/codec/grey_stage-inl.h"

void decode16(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
              SymbolReader& symbols) {
  decode_stage(p, stage, work, symbols);
}

void encode16(const Parameters& p, const Stage& stage, Workspace<std::int16_t>& work,
              const Truth<std::int16_t>& truth, std::vector<Symbol>& symbols) {
  encode_stage(p, stage, work, truth, symbols);
}

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace octavo::grey {

HWY_EXPORT(decode16);
HWY_EXPORT(encode16);

const StageFunctions& stage_functions() {
  static const StageFunctions functions = [] {
    const char* const asked = std::getenv("OCTAVO_SIMD");
    StageFunctions chosen = portable_stage_functions();
    if (asked != nullptr && std::string_view(asked) == "scalar") return chosen;
    // Without this the table would still hold the function that detects the machine at every call.
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    chosen.decode16 = HWY_DYNAMIC_DISPATCH(decode16);
    chosen.encode16 = HWY_DYNAMIC_DISPATCH(encode16);
    return chosen;
  }();
  return functions;
}

}  // namespace octavo::grey
#endif
