// Residuals off the rANS streams, vectorized: tokens first, as many states at a time as there are
// lanes, then the plain bits of the row.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_SYMBOLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_SYMBOLS_INL_H
#undef OCTAVO_CODEC_GREY_SYMBOLS_INL_H
#else
#define OCTAVO_CODEC_GREY_SYMBOLS_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <type_traits>

#include "octavo/codec/grey/grey_portable.h"

// Places within a row are small numbers.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)
HWY_BEFORE_NAMESPACE();
namespace octavo::grey {
namespace HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR

namespace hn = hwy::HWY_NAMESPACE;

constexpr hn::CappedTag<std::uint32_t, 8> kWords{};
constexpr hn::Rebind<std::uint16_t, decltype(kWords)> kShortWords{};
using Words = hn::Vec<decltype(kWords)>;
inline constexpr int kStateLanes = static_cast<int>(hn::MaxLanes(kWords));

/// Symbols whose plain bits are taken together: their bits fit in 64.
inline constexpr int kChunk = 8;
constexpr hn::FixedTag<std::uint8_t, kChunk> kChunkBytes{};
constexpr hn::FixedTag<std::uint16_t, kChunk> kChunkHalves{};
using ChunkHalves = hn::Vec<decltype(kChunkHalves)>;

/// For every set of lanes that need a word: which of the next words each of them gets.
struct WordPlaces {
  std::uint64_t places[std::size_t{1} << kStateLanes];  ///< a byte per lane, the first lowest
};
constexpr WordPlaces make_word_places() {
  WordPlaces made{};
  for (std::size_t set = 0; set < std::size(made.places); ++set) {
    std::uint64_t next = 0;
    for (int lane = 0; lane < kStateLanes; ++lane) {
      made.places[set] |= next << 8 * lane;
      next += set >> lane & 1;
    }
  }
  return made;
}
alignas(64) inline constexpr WordPlaces kWordPlaces = make_word_places();

constexpr hn::FixedTag<std::uint32_t, 4> kFourWords{};

/// Single loads overlap better than a gather instruction where that is microcode.
HWY_INLINE hn::Vec<decltype(kFourWords)> load_four(const std::uint32_t* from,
                                                   const std::uint32_t* places) {
#if HWY_ARCH_WASM
  // Loads into lanes, of which Highway makes shuffles.
  v128_t found = wasm_v128_load32_zero(from + places[0]);
  found = wasm_v128_load32_lane(from + places[1], found, 1);
  found = wasm_v128_load32_lane(from + places[2], found, 2);
  return hn::Vec<decltype(kFourWords)>{wasm_v128_load32_lane(from + places[3], found, 3)};
#else
  const hn::FixedTag<std::uint32_t, 1> single;
  const hn::FixedTag<std::uint32_t, 2> two;
  const auto first = hn::Combine(two, hn::Load(single, from + places[1]),
                                 hn::Load(single, from + places[0]));
  const auto last = hn::Combine(two, hn::Load(single, from + places[3]),
                                hn::Load(single, from + places[2]));
  return hn::Combine(kFourWords, last, first);
#endif
}
HWY_INLINE Words load_eight(const std::uint32_t* from, const std::uint32_t* places) {
#if HWY_MAX_BYTES >= 32
  return hn::Combine(kWords, load_four(from, places + 4), load_four(from, places));
#else
  return load_four(from, places);
#endif
}

/// The table entries at the places of every lane.
template <class D>
HWY_INLINE hn::Vec<D> load_each(D d, const std::uint32_t* from, hn::Vec<D> index) {
  alignas(64) std::uint32_t places[hn::MaxLanes(d)];
  hn::Store(index, d, places);
#if HWY_COMPILER_GCC || HWY_COMPILER_CLANG
  // Reloading is cheaper than taking lanes out of the vector, which compilers would make of it.
  __asm__("" : "+m"(places));
#endif
  if constexpr (hn::MaxLanes(d) <= 8) return load_eight(from, places);
  else return hn::Combine(d, load_eight(from, places + 8), load_eight(from, places));
}

#if HWY_ARCH_WASM
/// For every set of lanes that need a word: where the bytes of the vector come from, out of the
/// next words; what lies beyond them is 0.
struct WordBytes {
  std::uint8_t from[std::size_t{1} << kStateLanes][16];
};
constexpr WordBytes make_word_bytes() {
  WordBytes made{};
  for (std::size_t set = 0; set < std::size(made.from); ++set) {
    for (int lane = 0; lane < kStateLanes; ++lane) {
      const auto word = static_cast<std::uint8_t>(kWordPlaces.places[set] >> 8 * lane);
      std::uint8_t* const bytes = made.from[set] + 4 * lane;
      bytes[0] = static_cast<std::uint8_t>(2 * word);
      bytes[1] = static_cast<std::uint8_t>(2 * word + 1);
      bytes[2] = bytes[3] = 0xff;
    }
  }
  return made;
}
alignas(16) inline constexpr WordBytes kWordBytes = make_word_bytes();
#endif

/// States with the next words below those that became low.
/// moving  a bit for each lane that gets a word then
template <class D>
HWY_INLINE hn::Vec<D> refilled(D d, hn::Vec<D> stepped, unsigned moving,
                               const std::uint8_t*& words) {
  const auto is_low = hn::Eq(hn::ShiftRight<16>(stepped), hn::Zero(d));
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
  const unsigned low = static_cast<unsigned>(is_low.raw) & moving;
  const hn::Rebind<std::uint16_t, D> shorts;
  const auto next =
      hn::PromoteTo(d, hn::LoadU(shorts, reinterpret_cast<const std::uint16_t*>(words)));
  hn::Vec<D> spread;
  if constexpr (hn::MaxLanes(d) == 16) {
    spread.raw = _mm512_maskz_expand_epi32(static_cast<__mmask16>(low), next.raw);
  } else {
    spread.raw = _mm256_maskz_expand_epi32(static_cast<__mmask8>(low), next.raw);
  }
#else
  std::uint8_t low_lanes[8];
  hn::StoreMaskBits(d, is_low, low_lanes);
  const auto low = static_cast<std::uint8_t>(low_lanes[0] & moving);
#if HWY_ARCH_WASM
  const hn::Vec<D> spread{wasm_i8x16_swizzle(wasm_v128_load64_zero(words),
                                             wasm_v128_load(kWordBytes.from[low]))};
#else
  const hn::Rebind<std::uint16_t, D> shorts;
  const hn::Rebind<std::uint8_t, D> bytes;
  const auto next =
      hn::PromoteTo(d, hn::LoadU(shorts, reinterpret_cast<const std::uint16_t*>(words)));
  const auto places = hn::PromoteTo(
      d, hn::LoadU(bytes, reinterpret_cast<const std::uint8_t*>(kWordPlaces.places + low)));
  const auto spread = hn::TableLookupLanes(next, hn::IndicesFromVec(d, places));
#endif
#endif
  words += 2 * std::popcount(low);
  return hn::IfThenElse(is_low, hn::Or(hn::ShiftLeft<16>(stepped), spread), stepped);
}

/// What the states of a stream share while tokens are taken off them.
template <class D>
struct TokenStream {
  static constexpr D kStates{};
  static constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
  static constexpr hn::Rebind<std::uint16_t, D> kShorts{};
  using V = hn::Vec<D>;

  const std::uint32_t* slots;
  const std::uint8_t* words;
  V all;  ///< the bits that any token has

  /// One symbol off each state of a vector.
  HWY_INLINE void take(const std::uint16_t* contexts, V& state, std::uint16_t* tokens) {
    put(step(contexts_at(contexts), (1u << kLanes) - 1, state), tokens);
  }
  /// The same of the first `count` states.
  HWY_INLINE void take_some(const std::uint16_t* contexts, int count, V& state,
                            std::uint16_t* tokens) {
    const auto is_moving = hn::FirstN(kStates, static_cast<std::size_t>(count));
    const V before = state;
    const V token = step(hn::IfThenElseZero(is_moving, contexts_at(contexts)), (1u << count) - 1,
                         state);
    state = hn::IfThenElse(is_moving, state, before);
    put(hn::IfThenElseZero(is_moving, token), tokens);
  }

 private:
  static HWY_INLINE V contexts_at(const std::uint16_t* contexts) {
    return hn::And(hn::PromoteTo(kStates, hn::LoadU(kShorts, contexts)),
                   hn::Set(kStates, 0xff));
  }
  HWY_INLINE V step(V context, unsigned moving, V& state) {
    const auto set = [](std::uint32_t value) HWY_ATTR { return hn::Set(kStates, value); };
    const V slot = hn::Or(hn::ShiftLeft<kTableBits>(context), hn::And(state, set(kTableSize - 1)));
    const V entry = load_each(kStates, slots, slot);
    const V stepped = hn::Add(hn::Mul(hn::And(hn::ShiftRight<6>(entry), set(0xfff)),
                                      hn::ShiftRight<kTableBits>(state)),
                              hn::ShiftRight<18>(entry));
    state = refilled(kStates, stepped, moving, words);
    return hn::And(entry, set(63));
  }
  HWY_INLINE void put(V token, std::uint16_t* tokens) {
    const hn::RebindToSigned<D> ints;
    all = hn::Or(all, token);
    hn::StoreU(hn::DemoteTo(kShorts, hn::BitCast(ints, token)), kShorts, tokens);
  }
};

/// No states: what stands behind the last vector of them.
template <class D>
struct NoStates {
  HWY_INLINE void load(const std::uint32_t*) {}
  HWY_INLINE void store(std::uint32_t*) const {}
  HWY_INLINE void take_round(TokenStream<D>&, const std::uint16_t*, std::uint16_t*) {}
  HWY_INLINE void take_rest(TokenStream<D>&, const std::uint16_t*, int, std::uint16_t*) {}
};

/// Vectors of states, one by one: compilers keep no arrays in registers.
template <class D, int kVectors>
struct StateVectors {
  static constexpr int kLanes = TokenStream<D>::kLanes;

  HWY_INLINE void load(const std::uint32_t* from) {
    first = hn::Load(D(), from);
    others.load(from + kLanes);
  }
  HWY_INLINE void store(std::uint32_t* to) const {
    hn::Store(first, D(), to);
    others.store(to + kLanes);
  }
  HWY_INLINE void take_round(TokenStream<D>& stream, const std::uint16_t* contexts,
                             std::uint16_t* tokens) {
    stream.take(contexts, first, tokens);
    others.take_round(stream, contexts + kLanes, tokens + kLanes);
  }
  /// Less than a round.
  HWY_INLINE void take_rest(TokenStream<D>& stream, const std::uint16_t* contexts, int count,
                            std::uint16_t* tokens) {
    if (count >= kLanes) {
      stream.take(contexts, first, tokens);
      others.take_rest(stream, contexts + kLanes, count - kLanes, tokens + kLanes);
    } else if (count > 0) {
      stream.take_some(contexts, count, first, tokens);
    }
  }

  hn::Vec<D> first;
  std::conditional_t<kVectors == 1, NoStates<D>, StateVectors<D, kVectors - 1>> others;
};

/// The kStates states of a stream, held in registers while tokens are taken off them.
template <int kStates>
class TokenStates {
 public:
  HWY_INLINE explicit TokenStates(const SymbolReader& symbols)
      : stream_{symbols.slots, symbols.words, hn::Zero(D())} {
    states_.load(symbols.states);
  }
  HWY_INLINE void give_back(SymbolReader& symbols) const {
    states_.store(symbols.states);
    symbols.words = stream_.words;
  }

  /// One symbol off each state.
  HWY_INLINE void take_round(const std::uint16_t* contexts, std::uint16_t* tokens) {
    states_.take_round(stream_, contexts, tokens);
  }

  /// The tokens of a row from its i-th symbol on, a multiple of kStates. What lies behind the last
  /// context and the last token is anything.
  HWY_INLINE void take_rest(const std::uint16_t* contexts, int i, int count,
                            std::uint16_t* tokens) {
    for (; i + kStates <= count; i += kStates) take_round(contexts + i, tokens + i);
    states_.take_rest(stream_, contexts + i, count - i, tokens + i);
  }

  /// Whether any token has bits of its own, beyond the plain bits of its context.
  HWY_INLINE bool is_any_big() const {
    const hn::RebindToSigned<D> ints;
    return !hn::AllFalse(
        ints, hn::TestBit(hn::BitCast(ints, stream_.all), hn::Set(ints, kDirectTokens)));
  }

 private:
  using D = hn::CappedTag<std::uint32_t, std::min(kStates, 16)>;
  static constexpr int kVectors = kStates / TokenStream<D>::kLanes;

  TokenStream<D> stream_;
  StateVectors<D, kVectors> states_;
};

/// Symbols of some rows, side by side: how many each row has, all their contexts, and room for
/// their tokens and a vector more.
struct TokenRows {
  const int* counts = nullptr;
  int row_count = 0;
  const std::uint16_t* contexts = nullptr;
  std::uint16_t* tokens = nullptr;
};

/// Takes the tokens of some rows from one of them on, whose contexts and tokens come first. Every
/// row starts with the first state.
template <int kStates>
HWY_INLINE void take_rows_from(TokenStates<kStates>& states, int first, const TokenRows& rows) {
  int at = 0;
  for (int r = first; r < rows.row_count; ++r) {
    states.take_rest(rows.contexts + at, 0, rows.counts[r], rows.tokens + at);
    at += rows.counts[r];
  }
}

/// Takes the tokens of some rows; gives whether any is big.
template <int kStates>
bool take_rows_of(SymbolReader& symbols, const TokenRows& rows) {
  TokenStates<kStates> states(symbols);
  take_rows_from(states, 0, rows);
  states.give_back(symbols);
  return states.is_any_big();
}

/// Few symbols have few states.
inline bool take_rows_of_few(SymbolReader& symbols, const TokenRows& rows) {
  std::uint32_t any = 0;
  int at = 0;
  for (int r = 0; r < rows.row_count; ++r) {
    for (int i = 0; i < rows.counts[r]; ++i, ++at) {
      const int token = symbols.take_token(i, rows.contexts[at] & 0xff);
      rows.tokens[at] = static_cast<std::uint16_t>(token);
      any |= static_cast<std::uint32_t>(token);
    }
  }
  return (any & kDirectTokens) != 0;
}

inline bool take_token_rows(SymbolReader& symbols, const TokenRows& rows) {
  switch (symbols.state_mask + 1) {
    case 32: return take_rows_of<32>(symbols, rows);
    case 16: return take_rows_of<16>(symbols, rows);
    case 8: return take_rows_of<8>(symbols, rows);
    default: return take_rows_of_few(symbols, rows);
  }
}

/// Rows of two streams that do not wait for each other; gives whether any token of each is big.
template <int kStates>
std::array<bool, 2> take_rows_of_both(SymbolReader& first, const TokenRows& rows,
                                      SymbolReader& second, const TokenRows& others) {
  TokenStates<kStates> a(first);
  TokenStates<kStates> b(second);
  TokenRows of_a = rows;
  TokenRows of_b = others;
  const int both = std::min(rows.row_count, others.row_count);
  for (int r = 0; r < both; ++r) {
    const int count_a = rows.counts[r];
    const int count_b = others.counts[r];
    int i = 0;
    for (; i + kStates <= std::min(count_a, count_b); i += kStates) {
      a.take_round(of_a.contexts + i, of_a.tokens + i);
      b.take_round(of_b.contexts + i, of_b.tokens + i);
    }
    a.take_rest(of_a.contexts, i, count_a, of_a.tokens);
    b.take_rest(of_b.contexts, i, count_b, of_b.tokens);
    of_a.contexts += count_a;
    of_a.tokens += count_a;
    of_b.contexts += count_b;
    of_b.tokens += count_b;
  }
  take_rows_from(a, both, of_a);
  take_rows_from(b, both, of_b);
  a.give_back(first);
  b.give_back(second);
  return {a.is_any_big(), b.is_any_big()};
}

inline std::array<bool, 2> take_token_rows(SymbolReader& first, const TokenRows& rows,
                                           SymbolReader& second, const TokenRows& others) {
  if (first.state_mask == 15 && second.state_mask == 15) {
    return take_rows_of_both<16>(first, rows, second, others);
  }
  if (first.state_mask == 7 && second.state_mask == 7) {
    return take_rows_of_both<8>(first, rows, second, others);
  }
  return {take_token_rows(first, rows), take_token_rows(second, others)};
}

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

HWY_INLINE hn::Vec<decltype(kChunkBytes)> bytes_of(std::uint64_t eight) {
  return hn::BitCast(kChunkBytes, hn::Set(hn::FixedTag<std::uint64_t, 1>(), eight));
}

/// Residuals in 16 bits stand for what does not fit at the ends of their range.
inline void put_residual(std::int64_t value, std::int32_t& residual) {
  residual = static_cast<std::int32_t>(value);
}
inline void put_residual(std::int64_t value, std::int16_t& residual) {
  residual = static_cast<std::int16_t>(std::clamp<std::int64_t>(value, -32768, 32767));
}
HWY_INLINE void store_residuals(hn::Vec<hn::FixedTag<std::int16_t, 8>> values,
                                std::int16_t* residuals) {
  hn::StoreU(values, hn::FixedTag<std::int16_t, 8>(), residuals);
}
HWY_INLINE void store_residuals(hn::Vec<hn::FixedTag<std::int16_t, 8>> values,
                                std::int32_t* residuals) {
  const hn::FixedTag<std::int32_t, 4> quad;
  const hn::FixedTag<std::int16_t, 4> half;
  hn::StoreU(hn::PromoteTo(quad, hn::LowerHalf(half, values)), quad, residuals);
  hn::StoreU(hn::PromoteTo(quad, hn::UpperHalf(half, values)), quad, residuals + 4);
}

/// Residuals of tokens and the plain bits below them.
template <class Residual>
void finish_residuals(SymbolReader& symbols, const std::uint16_t* contexts,
                      const std::uint16_t* tokens, int coded, bool has_big, Residual* residuals) {
  alignas(16) static constexpr std::uint8_t kMasks[16] = {0, 1, 3, 7, 15, 31, 63, 127};
  const hn::FixedTag<std::uint8_t, 16> table;
  const hn::RebindToSigned<decltype(kChunkHalves)> signed_halves;
  const auto masks = hn::Load(table, kMasks);
  const auto set = [](std::uint16_t value) HWY_ATTR { return hn::Set(kChunkHalves, value); };
  std::size_t at = symbols.plain_at;
  for (int i = 0; i < coded; i += kChunk) {
    const ChunkHalves token = hn::LoadU(kChunkHalves, tokens + i);
    const ChunkHalves packed = hn::LoadU(kChunkHalves, contexts + i);
    const int left = coded - i;
    if (HWY_UNLIKELY(has_big)) {
      const auto big = hn::And(token, set(kDirectTokens));
      if (left < kChunk || !hn::AllTrue(kChunkHalves, hn::Eq(big, hn::Zero(kChunkHalves)))) {
        symbols.plain_at = at;
        for (int k = i; k < std::min(coded, i + kChunk); ++k) {
          put_residual(symbols.value_of(tokens[k], contexts[k] >> 8), residuals[k]);
        }
        at = symbols.plain_at;
        continue;
      }
    }
    const auto counts = hn::DemoteTo(
        kChunkBytes, hn::BitCast(signed_halves, hn::ShiftRight<8>(packed)));
    const auto lane_masks = hn::TableLookupBytes(masks, counts);
    std::uint64_t mask = hn::GetLane(hn::BitCast(hn::FixedTag<std::uint64_t, 1>(), lane_masks));
    if (left < kChunk) mask &= (std::uint64_t{1} << 8 * left) - 1;
    const ChunkHalves plain =
        hn::PromoteTo(kChunkHalves, bytes_of(take_plain(symbols.plain, at, mask)));
    const ChunkHalves scale = hn::Add(hn::PromoteTo(kChunkHalves, lane_masks), set(1));
    const ChunkHalves value = hn::Add(hn::Mul(token, scale), plain);
    const ChunkHalves residual = hn::Xor(
        hn::ShiftRight<1>(value), hn::Sub(hn::Zero(kChunkHalves), hn::And(value, set(1))));
    store_residuals(hn::BitCast(signed_halves, residual), residuals + i);
  }
  symbols.plain_at = at;
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
