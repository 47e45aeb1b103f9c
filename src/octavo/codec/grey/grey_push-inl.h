// Residuals onto the rANS streams, vectorized: rows to tokens and plain bits; then tokens onto as
// many states at a time as there are lanes.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_PUSH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_PUSH_INL_H
#undef OCTAVO_CODEC_GREY_PUSH_INL_H
#else
#define OCTAVO_CODEC_GREY_PUSH_INL_H
#endif

#include <hwy/highway.h>

#include <bit>

#include "octavo/codec/grey/grey_residuals-inl.h"

HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

static_assert(kStateLanes <= static_cast<int>(kSpareWords));

/// The bits of 8 bytes that a mask takes out of each, side by side: take_plain the other way.
HWY_INLINE std::uint64_t gather_plain(std::uint64_t bytes, std::uint64_t mask) {
#if HWY_ARCH_X86_64 && HWY_TARGET <= HWY_AVX2
  return _pext_u64(bytes, mask);
#else
  std::uint64_t gathered = 0;
  int count = 0;
  for (int lane = 0; lane < kChunk; ++lane) {
    const std::uint64_t own = mask >> 8 * lane & 0xff;
    gathered |= (bytes >> 8 * lane & own) << count;
    count += std::popcount(own);
  }
  return gathered;
#endif
}

/// Adds the i-th residual of a row and the 7 behind it; nothing where one of their tokens is big or
/// has no slot.
HWY_INLINE bool write_chunk(const std::int32_t* residuals, const std::uint16_t* contexts, int i,
                            SymbolWriter& writer) {
  alignas(16) static constexpr std::uint8_t kMasks[16] = {0, 1, 3, 7, 15, 31, 63, 127};
  alignas(16) static constexpr std::uint8_t kParts[16] = {128, 64, 32, 16, 8, 4, 2, 1};
  const hn::FixedTag<std::uint8_t, 16> table;
  const hn::RebindToSigned<decltype(kChunkHalves)> signed_halves;
  const hn::FixedTag<std::int32_t, 4> quad;
  const hn::FixedTag<std::int16_t, 4> half;
  const auto set = [](std::uint16_t value) HWY_ATTR { return hn::Set(kChunkHalves, value); };
  // What does not fit in 16 bits stays big.
  const auto residual =
      hn::Combine(signed_halves, hn::DemoteTo(half, hn::LoadU(quad, residuals + i + 4)),
                  hn::DemoteTo(half, hn::LoadU(quad, residuals + i)));
  const ChunkHalves packed = hn::LoadU(kChunkHalves, contexts + i);
  const auto zigzag = hn::BitCast(
      kChunkHalves, hn::Xor(hn::ShiftLeft<1>(residual), hn::BroadcastSignBit(residual)));
  // Tokens, by a product in the place of a shift, and the plain bits below them
  const auto counts = hn::DemoteTo(
      kChunkBytes, hn::BitCast(signed_halves, hn::ShiftRight<8>(packed)));
  const auto lane_masks = hn::TableLookupBytes(hn::Load(table, kMasks), counts);
  const auto parts = hn::ShiftLeft<8>(
      hn::PromoteTo(kChunkHalves, hn::TableLookupBytes(hn::Load(table, kParts), counts)));
  const ChunkHalves token =
      hn::MulHigh(hn::ShiftLeft<1>(hn::Min(zigzag, set(0x7fff))), parts);
  const ChunkHalves big = hn::And(token, set(0xffff & ~(kDirectTokens - 1)));
  if (!hn::AllTrue(kChunkHalves, hn::Eq(big, hn::Zero(kChunkHalves)))) return false;
  const auto plain = hn::DemoteTo(
      kChunkBytes,
      hn::BitCast(signed_halves, hn::And(zigzag, hn::PromoteTo(kChunkHalves, lane_masks))));
  static_assert(kTokens == 1 << 6 && kContexts <= 0xff);
  std::uint16_t* const places = writer.next_places();
  hn::StoreU(hn::Add(hn::ShiftLeft<6>(hn::And(packed, set(0xff))), token), kChunkHalves, places);
  bool has_slots = true;
  for (int k = 0; k < kChunk; ++k) has_slots &= writer.encoders()[places[k]].frequency != 0;
  if (!has_slots) return false;
  hn::StoreU(hn::Iota(kChunkBytes, static_cast<std::uint8_t>(i % kMaxStates)), kChunkBytes,
             writer.next_states());
  const hn::FixedTag<std::uint64_t, 1> single;
  const std::uint64_t mask = hn::GetLane(hn::BitCast(single, lane_masks));
  writer.keep(kChunk, gather_plain(hn::GetLane(hn::BitCast(single, plain)), mask),
              std::popcount(mask));
  return true;
}

/// Adds the residuals of a row with their contexts.
inline void write_residuals(const std::int32_t* residuals, const std::uint16_t* contexts, int count,
                            SymbolWriter& writer) {
  writer.make_room(static_cast<std::size_t>(count));
  const auto add = [&](int i) {
    writer.add(Symbol(zigzag(std::int64_t{residuals[i]}), contexts[i], i));
  };
  int i = 0;
  for (; i + kChunk <= count; i += kChunk) {
    if (write_chunk(residuals, contexts, i, writer)) continue;
    for (int k = i; k < i + kChunk; ++k) add(k);
  }
  for (; i < count; ++i) add(i);
}

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
