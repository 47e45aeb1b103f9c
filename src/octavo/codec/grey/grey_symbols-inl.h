// Tokens off the rANS streams, vectorized: as many states at a time as there are lanes.
// Included once per instruction set by grey_stage_simd.cpp.

#if defined(OCTAVO_CODEC_GREY_SYMBOLS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OCTAVO_CODEC_GREY_SYMBOLS_INL_H
#undef OCTAVO_CODEC_GREY_SYMBOLS_INL_H
#else
#define OCTAVO_CODEC_GREY_SYMBOLS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>
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

#if HWY_ARCH_X86_64 && HWY_TARGET <= HWY_AVX3
/// Four table entries at the places of the lanes of a quarter, which go by registers: what is
/// stored takes longer to come back.
HWY_INLINE __m128i load_quarter(const std::uint32_t* from, __m128i places) {
  const auto low = static_cast<std::uint64_t>(_mm_cvtsi128_si64(places));
  const auto high = static_cast<std::uint64_t>(_mm_extract_epi64(places, 1));
  const auto entry = [from](std::uint64_t place) HWY_ATTR {
    return _mm_cvtsi32_si128(static_cast<int>(from[place]));
  };
  const __m128i first = _mm_unpacklo_epi32(entry(low & 0xffffffff), entry(low >> 32));
  const __m128i last = _mm_unpacklo_epi32(entry(high & 0xffffffff), entry(high >> 32));
  return _mm_unpacklo_epi64(first, last);
}
HWY_INLINE __m256i load_half(const std::uint32_t* from, __m256i places) {
  return _mm256_inserti128_si256(
      _mm256_castsi128_si256(load_quarter(from, _mm256_castsi256_si128(places))),
      load_quarter(from, _mm256_extracti128_si256(places, 1)), 1);
}
#endif

/// The table entries at the places of every lane.
template <class D>
HWY_INLINE hn::Vec<D> load_each(D d, const std::uint32_t* from, hn::Vec<D> index) {
#if HWY_ARCH_X86_64 && HWY_TARGET <= HWY_AVX3
  if constexpr (hn::MaxLanes(d) == 16) {
    return hn::Vec<D>{_mm512_inserti64x4(
        _mm512_castsi256_si512(load_half(from, _mm512_castsi512_si256(index.raw))),
        load_half(from, _mm512_extracti64x4_epi64(index.raw, 1)), 1)};
  }
#endif
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
  HWY_INLINE explicit NoStates(const std::uint32_t*) {}
  HWY_INLINE void store(std::uint32_t*) const {}
  HWY_INLINE void take_round(TokenStream<D>&, const std::uint16_t*, std::uint16_t*) {}
  HWY_INLINE void take_rest(TokenStream<D>&, const std::uint16_t*, int, std::uint16_t*) {}
};

/// Vectors of states, one by one: compilers keep no arrays in registers. Nor do they make vectors
/// of an instruction set in constructors that are not written out.
template <class D, int kVectors>
struct StateVectors {
  static constexpr int kLanes = TokenStream<D>::kLanes;

  HWY_INLINE explicit StateVectors(const std::uint32_t* from)
      : first(hn::Load(D(), from)), others(from + kLanes) {}
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
      : stream_{symbols.slots, symbols.words, hn::Zero(D())}, states_(symbols.states) {}
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
  using D = hn::CappedTag<std::uint32_t, std::min<std::size_t>(kStates, 16)>;
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

/// Takes the tokens of some rows; gives whether any is big. Every row starts with the first state.
template <int kStates>
HWY_NOINLINE bool take_rows_of(SymbolReader& symbols, const TokenRows& rows) {
  TokenStates<kStates> states(symbols);
  int at = 0;
  for (int r = 0; r < rows.row_count; ++r) {
    states.take_rest(rows.contexts + at, 0, rows.counts[r], rows.tokens + at);
    at += rows.counts[r];
  }
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

/// A stream and the rows whose tokens are taken off it.
struct StreamRows {
  SymbolReader* symbols = nullptr;
  TokenRows rows;
  bool has_big = false;  ///< whether any of the tokens is big, once they are taken
};

/// No streams: what stands behind the last one.
struct NoStreams {
  HWY_INLINE explicit NoStreams(const StreamRows*) {}
  HWY_INLINE void give_back(StreamRows*) const {}
  HWY_INLINE int row_count() const { return kMaxUnchecked; }
  HWY_INLINE int fewest(int) const { return kMaxUnchecked; }
  HWY_INLINE void take_round(int) {}
  HWY_INLINE void take_rest(int, int) {}
};

/// Streams that do not wait for each other, one by one: compilers keep no arrays in registers.
template <int kStates, int kCount>
struct StreamGroup {
  HWY_INLINE explicit StreamGroup(const StreamRows* streams)
      : states(*streams->symbols), rows(streams->rows), others(streams + 1) {}
  HWY_INLINE void give_back(StreamRows* streams) const {
    states.give_back(*streams->symbols);
    streams->has_big = states.is_any_big();
    others.give_back(streams + 1);
  }
  HWY_INLINE int row_count() const { return std::min(rows.row_count, others.row_count()); }
  /// The fewest symbols of the r-th row.
  HWY_INLINE int fewest(int r) const { return std::min(rows.counts[r], others.fewest(r)); }
  HWY_INLINE void take_round(int i) {
    states.take_round(rows.contexts + i, rows.tokens + i);
    others.take_round(i);
  }
  /// From the i-th symbol of the r-th row to its end.
  HWY_INLINE void take_rest(int r, int i) {
    const int count = rows.counts[r];
    states.take_rest(rows.contexts, i, count, rows.tokens);
    rows.contexts += count;
    rows.tokens += count;
    others.take_rest(r, i);
  }

  TokenStates<kStates> states;
  TokenRows rows;
  std::conditional_t<kCount == 1, NoStreams, StreamGroup<kStates, kCount - 1>> others;
};

/// The rows of a stream from the given one on, which not all streams have.
template <int kStates>
HWY_NOINLINE void take_rows_alone(StreamRows& stream, int first) {
  const TokenRows& rows = stream.rows;
  if (rows.row_count <= first) return;
  const int taken = std::accumulate(rows.counts, rows.counts + first, 0);
  const TokenRows others{rows.counts + first, rows.row_count - first, rows.contexts + taken,
                         rows.tokens + taken};
  stream.has_big |= take_rows_of<kStates>(*stream.symbols, others);
}

template <int kStates, int kCount>
void take_streams_of(StreamRows* streams) {
  StreamGroup<kStates, kCount> group(streams);
  const int shared = group.row_count();
  for (int r = 0; r < shared; ++r) {
    const int fewest = group.fewest(r);
    int i = 0;
    for (; i + kStates <= fewest; i += kStates) group.take_round(i);
    group.take_rest(r, i);
  }
  group.give_back(streams);
  for (StreamRows& one : std::span(streams, kCount)) take_rows_alone<kStates>(one, shared);
}

/// Streams of so many states, up to four at a time; two where vectors are so short that the states
/// of more take all registers.
template <int kStates>
void take_streams_of(std::span<StreamRows> streams) {
  constexpr std::size_t kAtOnce = kStateLanes < 8 ? 2 : 4;
  for (; streams.size() >= kAtOnce; streams = streams.subspan(kAtOnce)) {
    take_streams_of<kStates, kAtOnce>(streams.data());
  }
  switch (streams.size()) {
    case 3: return take_streams_of<kStates, 3>(streams.data());
    case 2: return take_streams_of<kStates, 2>(streams.data());
    case 1: return take_rows_alone<kStates>(streams.front(), 0);
    default: return;
  }
}

/// Takes the tokens of streams, at the same time of those next to each other that have as many
/// states.
inline void take_token_rows(std::span<StreamRows> streams) {
  while (!streams.empty()) {
    const std::size_t mask = streams.front().symbols->state_mask;
    std::size_t count = 1;
    while (count < streams.size() && streams[count].symbols->state_mask == mask) ++count;
    const std::span<StreamRows> alike = streams.first(count);
    switch (mask + 1) {
      case 32: take_streams_of<32>(alike); break;
      case 16: take_streams_of<16>(alike); break;
      case 8: take_streams_of<8>(alike); break;
      default:
        for (StreamRows& one : alike) one.has_big = take_rows_of_few(*one.symbols, one.rows);
    }
    streams = streams.subspan(count);
  }
}

#endif  // HWY_TARGET != HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace octavo::grey
HWY_AFTER_NAMESPACE();
// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)

#endif
