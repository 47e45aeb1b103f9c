// Residuals of tokens, vectorized: the plain bits below them, and their places in a row.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_RESIDUALS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_RESIDUALS_INL_H
#undef OCTAVO_CODEC_GREY_RESIDUALS_INL_H
#else
#define OCTAVO_CODEC_GREY_RESIDUALS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "octavo/codec/grey/grey_symbols-inl.h"

// Places within a row are small numbers.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

/// Symbols whose plain bits are taken together: their bits fit in 64.
inline constexpr int kChunk = 8;
constexpr hn::FixedTag<std::uint8_t, kChunk> kChunkBytes{};
constexpr hn::FixedTag<std::uint16_t, kChunk> kChunkHalves{};
using ChunkHalves = hn::Vec<decltype(kChunkHalves)>;

/// The plain bits of 8 symbols: as many to each byte of the result as the same byte of the mask
/// has.
HWY_INLINE std::uint64_t take_plain(const std::uint8_t* plain, std::size_t& at,
                                    std::uint64_t mask) {
  std::uint64_t word;
  std::memcpy(&word, plain + (at >> 3), 8);
  word >>= at & 7;
  at += static_cast<std::size_t>(__builtin_popcountll(mask));
#if HWY_ARCH_X86_64 && HWY_TARGET <= HWY_AVX2
  return _pdep_u64(word, mask);
#else
  std::uint64_t spread = 0;
  for (int lane = 0; lane < kChunk; ++lane) {
    const std::uint64_t own = mask >> 8 * lane & 0xff;
    spread |= (word & own) << 8 * lane;
    word >>= __builtin_popcountll(own);
  }
  return spread;
#endif
}

/// Residuals in 16 bits stand for what does not fit at the ends of their range.
inline void put_residual(std::int64_t value, std::int32_t& residual) {
  residual = static_cast<std::int32_t>(value);
}
inline void put_residual(std::int64_t value, std::int16_t& residual) {
  residual = static_cast<std::int16_t>(std::clamp<std::int64_t>(value, -32768, 32767));
}
/// Residuals of some tokens, all of one width.
template <class D, class Residual>
HWY_INLINE void put_residuals(D d, const std::uint16_t* tokens, const std::uint8_t* masks,
                              const std::uint8_t* plain, Residual* residuals) {
  const hn::Rebind<std::uint8_t, D> bytes;
  const hn::RebindToSigned<D> ints;
  const auto scale = hn::Add(hn::PromoteTo(d, hn::LoadU(bytes, masks)), hn::Set(d, 1));
  const auto value = hn::Add(hn::Mul(hn::LoadU(d, tokens), scale),
                             hn::PromoteTo(d, hn::LoadU(bytes, plain)));
  const auto residual = hn::BitCast(
      ints, hn::Xor(hn::ShiftRight<1>(value),
                    hn::Sub(hn::Zero(d), hn::And(value, hn::Set(d, 1)))));
  if constexpr (sizeof(Residual) == sizeof(std::int16_t)) {
    hn::StoreU(residual, ints, residuals);
  } else {
    const hn::RepartitionToWide<decltype(ints)> wide;
    const hn::Half<decltype(ints)> half;
    hn::StoreU(hn::PromoteTo(wide, hn::LowerHalf(half, residual)), wide, residuals);
    hn::StoreU(hn::PromoteTo(wide, hn::UpperHalf(half, residual)), wide,
               residuals + hn::MaxLanes(wide));
  }
}

/// The masks of the plain bits of some symbols, a byte each.
template <class D>
HWY_INLINE void put_masks(D d, const std::uint16_t* contexts, std::uint8_t* masks) {
  alignas(16) static constexpr std::uint8_t kMasks[16] = {0, 1, 3, 7, 15, 31, 63, 127};
  const hn::Rebind<std::uint8_t, D> bytes;
  const hn::RebindToSigned<D> ints;
  const auto packed = hn::ShiftRight<8>(hn::LoadU(d, contexts));
  const auto counts = hn::DemoteTo(bytes, hn::BitCast(ints, packed));
  if constexpr (hn::MaxLanes(bytes) < 16) {
    const auto table = hn::Load(hn::FixedTag<std::uint8_t, 16>(), kMasks);
    hn::StoreU(hn::TableLookupBytes(table, counts), bytes, masks);
  } else {
    hn::StoreU(hn::TableLookupBytes(hn::LoadDup128(bytes, kMasks), counts), bytes, masks);
  }
}

/// A token that has bits of its own.
struct BigToken {
  int place;
  std::uint64_t above;  ///< what stands above the plain bits of its context
};

/// Marks the big ones of some tokens, a bit each, lowest first.
template <class D>
HWY_INLINE void put_big_lanes(D d, const std::uint16_t* tokens, std::uint8_t* lanes) {
  const auto big = hn::TestBit(hn::LoadU(d, tokens), hn::Set(d, kDirectTokens));
  std::uint8_t bits[8];
  constexpr std::size_t kBytes = hn::MaxLanes(D()) / kChunk;
  hn::StoreMaskBits(d, big, bits);
  std::memcpy(lanes, bits, kBytes);
}

/// Residuals of at most kMaxUnchecked tokens and the plain bits below them. Step by step for all
/// of them: what one step leaves in memory has settled there when the next one reads it in larger
/// pieces.
template <class Residual>
void finish_residuals(SymbolReader& symbols, const std::uint16_t* contexts,
                      const std::uint16_t* tokens, int coded, bool has_big, Residual* residuals) {
  // The room behind residuals is for no more than a chunk.
  constexpr hn::CappedTag<std::uint16_t, sizeof(Residual) == 2 ? 32 : kChunk> kMany{};
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(kMany));
  alignas(64) std::uint8_t masks[kMaxUnchecked + kChunk];
  alignas(64) std::uint8_t plain[kMaxUnchecked + kChunk];
  int i = 0;
  for (; i + kLanes <= coded; i += kLanes) put_masks(kMany, contexts + i, masks + i);
  for (; i < coded; i += kChunk) put_masks(kChunkHalves, contexts + i, masks + i);
  std::memset(masks + coded, 0, kChunk);
  std::uint8_t big_lanes[kMaxUnchecked / kChunk + 1];
  if (has_big) {
    for (i = 0; i + kLanes <= coded; i += kLanes) {
      put_big_lanes(kMany, tokens + i, big_lanes + i / kChunk);
    }
    for (; i < coded; i += kChunk) put_big_lanes(kChunkHalves, tokens + i, big_lanes + i / kChunk);
    // Behind the last token stands anything.
    const int last = coded % kChunk;
    if (last != 0) big_lanes[coded / kChunk] &= static_cast<std::uint8_t>((1 << last) - 1);
  }

  BigToken bigs[kMaxUnchecked];
  int big_count = 0;
  std::size_t at = symbols.plain_at;
  for (i = 0; i < coded; i += kChunk) {
    std::uint64_t mask;
    std::memcpy(&mask, masks + i, kChunk);
    std::uint64_t bits = 0;
    if (HWY_UNLIKELY(has_big)) {
      for (unsigned lanes = big_lanes[i / kChunk]; lanes != 0; lanes &= lanes - 1) {
        // The bits of those up to it, then its own
        const int lane = std::countr_zero(lanes);
        const std::uint64_t first = mask & ~std::uint64_t{0} >> (56 - 8 * lane);
        bits |= take_plain(symbols.plain, at, first);
        mask ^= first;
        symbols.plain_at = at;
        bigs[big_count++] = {i + lane, symbols.take_above(tokens[i + lane])};
        at = symbols.plain_at;
      }
    }
    bits |= take_plain(symbols.plain, at, mask);
    std::memcpy(plain + i, &bits, kChunk);
  }
  symbols.plain_at = at;

  for (i = 0; i + kLanes <= coded; i += kLanes) {
    put_residuals(kMany, tokens + i, masks + i, plain + i, residuals + i);
  }
  for (; i < coded; i += kChunk) {
    put_residuals(kChunkHalves, tokens + i, masks + i, plain + i, residuals + i);
  }
  for (int k = 0; k < big_count; ++k) {
    const auto [place, above] = bigs[k];
    const std::uint64_t value = (above << (contexts[place] >> 8)) + plain[place];
    put_residual(unzigzag(value), residuals[place]);
  }
}

HWY_INLINE hn::Vec<decltype(kChunkBytes)> bytes_of(std::uint64_t eight) {
  return hn::BitCast(kChunkBytes, hn::Set(hn::FixedTag<std::uint64_t, 1>(), eight));
}

/// For every set of 8 lanes: its lanes one after the other, a byte each, the first lowest.
struct LaneLists {
  std::uint64_t lists[std::size_t{1} << kChunk];
};
constexpr LaneLists make_lane_lists() {
  LaneLists made{};
  for (std::uint64_t set = 0; set < std::size(made.lists); ++set) {
    int count = 0;
    for (std::uint64_t lane = 0; lane < kChunk; ++lane) {
      if ((set >> lane & 1) != 0) made.lists[set] |= lane << 8 * count++;
    }
  }
  return made;
}
alignas(64) inline constexpr LaneLists kLaneLists = make_lane_lists();

/// Puts the contexts of some pairs of a row side by side, into a place of their own with room for a
/// chunk more, or where they stand.
inline void gather_contexts(RowMask coded, int count, const std::uint16_t* contexts,
                            std::uint16_t* to) {
  const auto set = [](std::uint16_t value) HWY_ATTR { return hn::Set(kChunkHalves, value); };
  for (int x = 0; x < count; x += kChunk) {
    const auto lanes = static_cast<std::uint8_t>(coded >> x);
    // A lane to the places of its two bytes
    const ChunkHalves list = hn::PromoteTo(kChunkHalves, bytes_of(kLaneLists.lists[lanes]));
    const ChunkHalves places = hn::Add(hn::Mul(list, set(0x0202)), set(0x0100));
    hn::StoreU(hn::TableLookupBytes(hn::LoadU(kChunkHalves, contexts + x), places), kChunkHalves,
               to);
    to += std::popcount(lanes);
  }
}

/// Spreads residuals over some pairs of a row; the other pairs have 0.
template <class Residual>
void spread_residuals(RowMask coded, int count, const Residual* found, Residual* residuals) {
  const hn::RebindToSigned<decltype(kWords)> ints;
  const hn::Rebind<Residual, decltype(kWords)> stored;
  const hn::Rebind<std::uint8_t, decltype(kWords)> bytes;
  for (int x = 0; x < count; x += kStateLanes) {
    const auto lanes = static_cast<std::uint8_t>(coded >> x & ((1u << kStateLanes) - 1));
    const Words places = hn::PromoteTo(
        kWords,
        hn::LoadU(bytes, reinterpret_cast<const std::uint8_t*>(kWordPlaces.places + lanes)));
    const auto indices = hn::IndicesFromVec(ints, hn::BitCast(ints, places));
    const auto mask = hn::LoadMaskBits(ints, &lanes);
    if constexpr (sizeof(Residual) == sizeof(std::int32_t)) {
      const auto next = hn::LoadU(ints, found);
      hn::StoreU(hn::IfThenElseZero(mask, hn::TableLookupLanes(next, indices)), ints,
                 residuals + x);
    } else {
      const auto next = hn::PromoteTo(ints, hn::LoadU(stored, found));
      const auto spread = hn::IfThenElseZero(mask, hn::TableLookupLanes(next, indices));
      hn::StoreU(hn::DemoteTo(stored, spread), stored, residuals + x);
    }
    found += std::popcount(lanes);
  }
}

/// Residuals of a row off the streams: PortableKernel::take_row. Residuals are padded to a multiple
/// of 8.
template <class Residual>
void take_residuals(SymbolReader& symbols, std::uint16_t* contexts, RowMask pairs, int count,
                    Residual* residuals) {
  alignas(64) std::uint16_t tokens[kBrickSide + 2 * kChunk];
  Residual found[kBrickSide + 2 * kChunk];
  const int coded = std::popcount(pairs);
  if (coded < count) gather_contexts(pairs, count, contexts, contexts);
  const bool has_big = take_token_rows(symbols, {&coded, 1, contexts, tokens});
  // The last chunk may reach beyond the row, and so into what pads residuals and magnitudes.
  hn::StoreU(hn::Zero(kChunkHalves), kChunkHalves, tokens + coded);
  finish_residuals(symbols, contexts, tokens, coded, has_big, coded < count ? found : residuals);
  symbols.expect_inside();
  if (coded < count) spread_residuals(pairs, count, found, residuals);
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
