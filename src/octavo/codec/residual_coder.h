// Residuals to bytes and back: tokens through interleaved static-table rANS, low bits stored plain.
//
// A detail segment is
//     varint  length of the plain bits, in bytes
//     plain bits, lowest bit first
//     S states, u32 each; then u16 words to the end
// rANS (Duda 2013) with 32-bit states, 16-bit renormalisation and tables of 2048 slots. The j-th
// coded symbol of a row uses state j mod S; S grows with the number of symbols (see state_count). A
// decoder that took every symbol has all states back at 2^16, has read all words and all plain
// bits: a check for free.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/codec/byte_io.h"
#include "octavo/codec/grey_model.h"

namespace octavo::grey {

inline constexpr std::uint32_t kStateFloor = 1u << 16;
inline constexpr int kMaxStates = 32;

/// Interleaved states of a segment of that many symbols.
constexpr int state_count(std::int64_t symbols) {
  return symbols >= 16384 ? kMaxStates : symbols >= 1024 ? 8 : symbols >= 128 ? 2 : 1;
}

/// A residual waiting to be written.
struct Symbol {
  std::uint64_t value;  ///< zigzag residual
  std::uint8_t context;
  std::uint8_t state;
};

/// The bytes of one segment. shift: low bits of every value that are always plain (wide samples).
Bytes encode_symbols(const Model& model, int set, const std::vector<Symbol>& symbols, int shift);

/// Takes residuals off a segment, row by row.
class SymbolReader {
 public:
  /// Throws Error{corrupt} when the segment is too short for its own head.
  SymbolReader(const Model& model, int set, ByteSpan segment, std::int64_t symbol_count, int shift);

  /// Residuals of a row: `contexts[order[i]]` is the context and `residuals[order[i]]` the result
  /// of the i-th coded symbol.
  template <class Int>
  void take_row(const std::uint8_t* contexts, const std::uint8_t* order, int count,
                Int* residuals) {
    for (int i = 0; i < count; ++i) {
      const int x = order[i];
      std::uint32_t& state = states_[static_cast<std::size_t>(i) & state_mask_];
      const unsigned context = contexts[x];
      const std::uint32_t entry = (*slots_)[context][state & (kTableSize - 1)];
      state = (entry >> 6 & 0xfff) * (state >> kTableBits) + (entry >> 18);
      const std::uint32_t low = state < kStateFloor;
      const std::uint32_t word = word_at_ < words_.size() ? load_word() : 0u;
      state = low ? state << 16 | word : state;
      word_at_ += 2 * low;
      const std::uint32_t shape = shapes_[context][entry & 63];
      const int bits = static_cast<int>(shape & 31) + shift_;
      std::uint64_t value = static_cast<std::uint64_t>(shape >> 5) << shift_;
      if (bits > 0) value += plain_.get(bits);
      residuals[x] = static_cast<Int>(unzigzag(value));
    }
  }

  /// Throws Error{corrupt} unless the segment was taken exactly.
  void finish() const;

 private:
  using Shapes = std::array<std::array<std::uint32_t, kTokens>, kContexts>;
  static const Shapes& token_shapes();

  std::uint32_t load_word() const {
    return static_cast<std::uint32_t>(words_[word_at_] | words_[word_at_ + 1] << 8);
  }

  const std::array<std::array<std::uint32_t, kTableSize>, kContexts>* slots_;
  const Shapes& shapes_;
  std::array<std::uint32_t, kMaxStates> states_{};
  std::size_t state_mask_ = 0;
  ByteSpan words_;
  std::size_t word_at_ = 0;
  BitReader plain_;
  int shift_;
};

}  // namespace octavo::grey
