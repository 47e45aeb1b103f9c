// Tokens onto the rANS streams, vectorized: as many states at a time as there are lanes.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_PUSH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_PUSH_INL_H
#undef OCTAVO_CODEC_GREY_PUSH_INL_H
#else
#define OCTAVO_CODEC_GREY_PUSH_INL_H
#endif

#include <hwy/highway.h>

#include <bit>

#include "octavo/codec/grey/grey_symbols-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

static_assert(kStateLanes <= static_cast<int>(kSpareWords));

/// For every set of lanes: its lanes one after the other in the last places, a byte each.
struct LastLanes {
  std::uint64_t lists[std::size_t{1} << kStateLanes];
};
constexpr LastLanes make_last_lanes() {
  LastLanes made{};
  for (std::uint64_t set = 0; set < std::size(made.lists); ++set) {
    int place = kStateLanes - std::popcount(set);
    for (std::uint64_t lane = 0; lane < kStateLanes; ++lane) {
      if ((set >> lane & 1) != 0) made.lists[set] |= lane << 8 * place++;
    }
  }
  return made;
}
alignas(64) inline constexpr LastLanes kLastLanes = make_last_lanes();

/// The encoders of as many tokens as there are lanes.
struct EncoderLanes {
  Words reciprocals;
  Words slots;  ///< frequency | start << 16

  HWY_INLINE EncoderLanes(const Encoder* encoders, const std::uint16_t* places) {
    static_assert(sizeof(Encoder) == sizeof(std::uint64_t));
    const hn::FixedTag<std::uint64_t, 1> single;
    const hn::FixedTag<std::uint64_t, 2> two;
    const auto pair = [&](std::size_t lane) HWY_ATTR {
      const auto one = [&](std::size_t k) HWY_ATTR {
        return hn::Load(single, reinterpret_cast<const std::uint64_t*>(encoders + places[k]));
      };
      return hn::Combine(two, one(lane + 1), one(lane));
    };
#if HWY_MAX_BYTES >= 32
    const hn::FixedTag<std::uint64_t, 4> four;
    const auto lower = hn::BitCast(kWords, hn::Combine(four, pair(2), pair(0)));
    const auto upper = hn::BitCast(kWords, hn::Combine(four, pair(6), pair(4)));
#else
    const auto lower = hn::BitCast(kWords, pair(0));
    const auto upper = hn::BitCast(kWords, pair(2));
#endif
    reciprocals = hn::ConcatEven(kWords, upper, lower);
    slots = hn::ConcatOdd(kWords, upper, lower);
  }
};

/// The upper halves of products.
HWY_INLINE Words upper_products(Words a, Words b) {
  const hn::RepartitionToWide<decltype(kWords)> wide;
  const auto even = hn::MulEven(a, b);
  const auto odd = hn::MulEven(hn::BitCast(kWords, hn::ShiftRight<32>(hn::BitCast(wide, a))),
                               hn::BitCast(kWords, hn::ShiftRight<32>(hn::BitCast(wide, b))));
  return hn::OddEven(hn::BitCast(kWords, odd), hn::BitCast(kWords, hn::ShiftRight<32>(even)));
}

/// Pushes a token onto each lane; gives the first of the words that leave the states.
HWY_INLINE std::uint16_t* push_lanes(const EncoderLanes& encoders, std::uint32_t* states,
                                     std::uint16_t* end) {
  const auto set = [](std::uint32_t value) HWY_ATTR { return hn::Set(kWords, value); };
  const hn::RebindToSigned<decltype(kWords)> ints;
  const hn::Rebind<std::uint8_t, decltype(kWords)> bytes;
  const Words x = hn::Load(kWords, states);
  const Words frequency = hn::And(encoders.slots, set(0xffff));
  // Words off the states that have no room
  const Words top = hn::ShiftRight<32 - kTableBits>(x);
  const auto is_full = hn::Eq(hn::Max(top, frequency), top);
  std::uint8_t full_lanes[8];
  hn::StoreMaskBits(kWords, is_full, full_lanes);
  const Words places = hn::PromoteTo(
      kWords,
      hn::LoadU(bytes, reinterpret_cast<const std::uint8_t*>(kLastLanes.lists + full_lanes[0])));
  const Words leaving =
      hn::And(hn::TableLookupLanes(x, hn::IndicesFromVec(kWords, places)), set(0xffff));
  hn::StoreU(hn::DemoteTo(kShortWords, hn::BitCast(ints, leaving)), kShortWords,
             end - kStateLanes);
  // Encoder::pushed
  const Words rest = hn::IfThenElse(is_full, hn::ShiftRight<16>(x), x);
  const Words low = upper_products(rest, encoders.reciprocals);
  const Words left = hn::Sub(rest, hn::Mul(low, frequency));
  const auto is_more = hn::Eq(hn::Max(left, frequency), left);
  const Words quotient = hn::Sub(low, hn::VecFromMask(kWords, is_more));
  const Words pushed =
      hn::Add(hn::Add(rest, hn::ShiftRight<16>(encoders.slots)),
              hn::Mul(quotient, hn::Sub(set(kTableSize), frequency)));
  hn::Store(pushed, kWords, states);
  return end - std::popcount(full_lanes[0]);
}

/// push_tokens.
inline std::uint16_t* push_token_vectors(const TokenRun& run, std::uint32_t* states,
                                         std::size_t state_mask, std::uint16_t* end) {
  if (state_mask + 1 < kStateLanes) return push_tokens(run, states, state_mask, end);
  // Where the last lane is met, the tokens before it in its row are those of the other lanes.
  const auto ends_vector = [&](std::size_t count) {
    return ((run.states[count - 1] & state_mask) + 1) % kStateLanes == 0;
  };
  std::size_t left = run.count;
  while (left > 0) {
    const std::size_t before = left;
    while (left > 0 && !ends_vector(left)) --left;
    end = push_tokens({run.encoders, run.places + left, run.states + left, before - left}, states,
                      state_mask, end);
    for (; left > 0 && ends_vector(left); left -= kStateLanes) {
      std::uint32_t* const first =
          states + ((run.states[left - 1] & state_mask) + 1 - kStateLanes);
      end = push_lanes(EncoderLanes(run.encoders, run.places + left - kStateLanes), first, end);
    }
  }
  return end;
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();

#endif
