// Residuals to bytes and back: tokens through interleaved static-table rANS, low bits stored plain.
//
// A detail segment is
//     varint  length of the plain bits, in bytes
//     plain bits, lowest bit first
//     S states, u32 each; then u16 words to the end
// rANS (Duda 2013) with 32-bit states, 16-bit renormalization and tables of 2048 slots. The j-th
// coded symbol of a row uses state j mod S; S grows with the number of symbols (see state_count). A
// decoder that took every symbol has all states back at 2^16, has read all words and all plain
// bits: a check for free.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "octavo/codec/entropy/byte_io.h"
#include "octavo/codec/grey/grey_model.h"
#include "octavo/core/recycled.h"

namespace octavo::grey {

inline constexpr std::uint32_t kStateFloor = 1u << 16;
inline constexpr int kMaxStates = 32;
static_assert(kMaxPlainBits <= 7);

/// Interleaved states of a segment of that many symbols.
constexpr int state_count(std::int64_t symbols) {
  return symbols >= 16384 ? kMaxStates : symbols >= 1024 ? 8 : symbols >= 128 ? 2 : 1;
}

/// A residual or the kind of an edge waiting to be written, in 8 bytes.
class Symbol {
 public:
  /// Not cleared: room for lists of them is made before they are written.
  Symbol() noexcept {}  // NOLINT(cppcoreguidelines-pro-type-member-init)
  /// packed: context | plain bits << 8; place: among the coded pairs of its row
  Symbol(std::uint64_t zigzag_residual, unsigned packed, int place)
      : Symbol(zigzag_residual, packed & 0xff, packed >> 8, place) {}
  /// context: of a pair that may be an edge, kContexts more than its own
  Symbol(std::uint64_t value, unsigned context, unsigned low_bits, int place)
      : bits_(value << 24 | std::uint64_t{context} | std::uint64_t{low_bits} << 16 |
              std::uint64_t{static_cast<unsigned>(place) % kMaxStates} << 19) {}

  std::uint64_t value() const { return bits_ >> 24; }  ///< zigzag residual, or kind and plain bit
  std::size_t context() const { return bits_ & 0xffff; }
  int low_bits() const { return bits_ >> 16 & 7; }     ///< lowest bits stored plain
  std::size_t state() const { return bits_ >> 19 & 31; }
  bool operator==(const Symbol&) const = default;

 private:
  std::uint64_t bits_;
};

/// Tokens of whole rows, waiting to be pushed onto states.
struct TokenRun {
  const Encoder* encoders;
  const std::uint16_t* places;  ///< of their encoders
  const std::uint8_t* states;   ///< of each the number of its state, Symbol::state
  std::size_t count;
};

/// Words in front of those that a run leaves which may be written to as well.
inline constexpr std::size_t kSpareWords = 8;

/// Pushes tokens, last one first, onto the states of a mask; words grow downwards from `end`. Gives
/// the first word.
using PushTokens = std::uint16_t* (*)(const TokenRun&, std::uint32_t* states,
                                      std::size_t state_mask, std::uint16_t* end);
std::uint16_t* push_tokens(const TokenRun& run, std::uint32_t* states, std::size_t state_mask,
                           std::uint16_t* end);

/// Makes a segment out of symbols. Keeps them in memory of the thread, which has one at a time.
class SymbolWriter {
 public:
  /// shift  low bits of every residual that are always plain (wide samples)
  SymbolWriter(const Model& model, int set, int shift, PushTokens push = push_tokens);

  /// Adds the symbols of whole rows.
  void add(std::span<const Symbol> symbols);

  /// What follows is open to the vectorized copies of `add`: a number of symbols that there is room
  /// for, symbols one by one, and tokens with slots whose encoders' places and states are written
  /// already.
  void make_room(std::size_t symbols);
  void add(const Symbol& symbol);
  const Encoder* encoders() const { return encoders_; }
  std::uint16_t* next_places() { return buffers_.places.data() + count_; }
  std::uint8_t* next_states() { return buffers_.states.data() + count_; }
  /// plain  at most 56 bits, lowest first
  void keep(std::size_t tokens, std::uint64_t plain, int plain_count) {
    count_ += tokens;
    put_plain(plain, plain_count);
  }

  /// The bytes of the segment; none without symbols.
  /// details      how many the level has: pairs that may be edges are asked for beside them
  /// most_states  a power of two; fewer details have fewer
  Bytes finish(std::int64_t details, int most_states = kMaxStates);

 private:
  /// What symbols have become: where their encoders stand, which states they go to, plain bits;
  /// and room for words.
  struct Buffers {
    std::vector<std::uint16_t> places;
    std::vector<std::uint8_t> states;
    std::vector<std::uint8_t> plain;
    std::vector<std::uint16_t> words;
  };
  static Buffers& thread_buffers();

  void put_plain(std::uint64_t value, int count) {
    std::uint8_t* const to = buffers_.plain.data() + plain_at_;
    pending_ |= value << pending_count_;
    pending_count_ += count;
    if constexpr (std::endian::native == std::endian::little) std::memcpy(to, &pending_, 8);
    else for (int i = 0; i < 8; ++i) to[i] = static_cast<std::uint8_t>(pending_ >> 8 * i);
    plain_at_ += static_cast<std::size_t>(pending_count_ >> 3);
    pending_ >>= pending_count_ & ~7;
    pending_count_ &= 7;
  }

  const Encoder* encoders_;
  const std::uint64_t* used_;
  int shift_;
  PushTokens push_;
  Buffers& buffers_;
  std::size_t count_ = 0;
  std::size_t plain_at_ = 0;   ///< whole bytes of plain bits
  std::uint64_t pending_ = 0;  ///< plain bits behind them
  int pending_count_ = 0;
};

/// The bytes of a segment of these symbols.
Bytes encode_symbols(const Model& model, int set, std::span<const Symbol> symbols,
                     std::int64_t details, int shift, int most_states = kMaxStates,
                     PushTokens push = push_tokens);

/// Symbols that may be taken off a segment from one check that it holds them to the next.
inline constexpr int kMaxUnchecked = 512;

/// Takes residuals off a segment, row by row. The members are open to the vectorized copies of
/// `take_row`; the streams are followed by enough zero bytes for kMaxUnchecked symbols beyond their
/// ends.
class SymbolReader {
 public:
  /// Throws Error{corrupt} when the segment is too short for its own head.
  SymbolReader(const Model& model, int set, ByteSpan segment, std::int64_t details, int shift,
               int most_states = kMaxStates);

  /// The residual of the i-th coded symbol of a row. packed: context | plain bits << 8
  std::int64_t take(int i, unsigned packed) {
    const int token = take_token(i, packed & 0xff);
    return value_of(token, static_cast<int>(packed >> 8) + shift);
  }

  /// The token of the i-th coded symbol of a row.
  int take_token(int i, unsigned context) {
    std::uint32_t& state = states[static_cast<std::size_t>(i) & state_mask];
    const std::uint32_t entry = slots[(context << kTableBits) + (state & (kTableSize - 1))];
    renew(state, (entry >> 6 & 0xfff) * (state >> kTableBits) + (entry >> 18));
    return static_cast<int>(entry & 63);
  }

  /// The kind of the i-th pair of a row that may be an edge.
  EdgeKind take_edge(int i, unsigned context) {
    std::uint32_t& state = states[static_cast<std::size_t>(i) & state_mask];
    const std::uint16_t* const starts = edge_starts[context].data();
    const std::uint32_t slot = state & (kTableSize - 1);
    const unsigned kind = (slot >= starts[1] ? 1u : 0u) + (slot >= starts[2] ? 1u : 0u);
    const std::uint32_t start = starts[kind];
    renew(state, (starts[kind + 1] - start) * (state >> kTableBits) + slot - start);
    return static_cast<EdgeKind>(kind);
  }

  /// The residual of a token, `low` plain bits below it.
  std::int64_t value_of(int token, int low) {
    const Token shape = token_shape(token);
    return unzigzag((std::uint64_t{shape.base} << low) + take_plain(shape.bits + low));
  }
  /// What a token with bits of its own stands for above the plain bits, which were taken before.
  std::uint64_t take_above(int token) {
    const Token shape = token_shape(token);
    return shape.base + take_plain(shape.bits);
  }

  std::uint64_t take_plain(int count) {
    std::uint64_t word;
    std::memcpy(&word, plain + (plain_at >> 3), 8);
    if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
    word >>= plain_at & 7;
    plain_at += static_cast<std::size_t>(count);
    return word & ((std::uint64_t{1} << count) - 1);
  }

  /// Throws Error{corrupt} when more was taken than the segment holds.
  void expect_inside() const {
    if (words > words_end || plain_at > plain_end) fail_short();
  }

  /// Throws Error{corrupt} unless the segment was taken exactly.
  void finish() const;

  alignas(64) std::uint32_t states[kMaxStates] = {};
  std::size_t state_mask = 0;
  const std::uint32_t* slots;        ///< of the table set, by context and slot
  const std::array<std::uint16_t, kEdgeKinds + 1>* edge_starts;  ///< of the model, by context
  const std::uint8_t* words;         ///< next word
  const std::uint8_t* words_end;
  const std::uint8_t* plain;         ///< first byte of the plain bits
  std::size_t plain_at = 0;          ///< next plain bit
  std::size_t plain_end;
  int shift;

 private:
  [[noreturn]] static void fail_short();

  /// Without a branch: whether a word is due is anyone's guess.
  void renew(std::uint32_t& state, std::uint32_t stepped) {
    const bool is_low = stepped < kStateFloor;
    const std::uint32_t filled =
        stepped << 16 | static_cast<std::uint32_t>(words[0] | words[1] << 8);
    state = is_low ? filled : stepped;
    words += is_low ? 2 : 0;
  }

  Recycled<UnsetBytes, SymbolReader> padded_;
};

}  // namespace octavo::grey
