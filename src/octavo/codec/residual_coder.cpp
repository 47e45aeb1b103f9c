#include "octavo/codec/residual_coder.h"

#include <algorithm>

namespace octavo::grey {

namespace {

/// A symbol takes at most one word and 42 plain bits; vectors read ahead by 16 bytes.
constexpr std::size_t kWordPadding = kMaxUnchecked * 2 + 32;
constexpr std::size_t kPlainPadding = kMaxUnchecked * 42 / 8 + 32;

void put_u16(Bytes& out, std::uint32_t value) {
  out.push_back(static_cast<std::uint8_t>(value));
  out.push_back(static_cast<std::uint8_t>(value >> 8));
}

struct SplitSymbol {
  int token;
  int bits;
  std::uint64_t plain;
};

/// How a symbol is written under `frequencies`: tokens without a slot go through the escape token.
SplitSymbol split(const std::array<std::uint16_t, kTokens>& frequencies, const Symbol& symbol,
                  int shift) {
  const int low = symbol.low_bits + shift;
  int token = token_of(static_cast<std::uint32_t>(symbol.value >> low));
  if (frequencies[static_cast<std::size_t>(token)] == 0) token = kEscapeToken;
  const int bits = token_shape(token).bits + low;
  return {token, bits, symbol.value & ((std::uint64_t{1} << bits) - 1)};
}

}  // namespace

Bytes encode_symbols(const Model& model, int set, const std::vector<Symbol>& symbols, int shift) {
  const auto table = static_cast<std::size_t>(set);
  const auto states =
      static_cast<std::size_t>(state_count(static_cast<std::int64_t>(symbols.size())));

  // Plain bits forwards, tokens backwards: rANS is a stack.
  Bytes plain;
  BitWriter bits(plain);
  std::vector<std::uint8_t> tokens(symbols.size());
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    const SplitSymbol s =
        split(model.parameters.frequencies[table][symbols[i].context], symbols[i], shift);
    tokens[i] = static_cast<std::uint8_t>(s.token);
    bits.put(s.plain, s.bits);
  }
  bits.finish();

  std::array<std::uint32_t, kMaxStates> state;
  state.fill(kStateFloor);
  std::vector<std::uint16_t> words;
  for (std::size_t i = symbols.size(); i-- > 0;) {
    const Symbol& symbol = symbols[i];
    const std::uint32_t frequency = model.parameters.frequencies[table][symbol.context][tokens[i]];
    const std::uint32_t start = model.tables.starts[table][symbol.context][tokens[i]];
    std::uint32_t& x = state[symbol.state & (states - 1)];
    if (x >= std::uint64_t{frequency} << (32 - kTableBits)) {
      words.push_back(static_cast<std::uint16_t>(x));
      x >>= 16;
    }
    x = ((x / frequency) << kTableBits) + x % frequency + start;
  }

  Bytes out;
  put_varint(out, plain.size());
  out.insert(out.end(), plain.begin(), plain.end());
  for (std::size_t i = 0; i < states; ++i) {
    put_u16(out, state[i]);
    put_u16(out, state[i] >> 16);
  }
  for (std::size_t i = words.size(); i-- > 0;) put_u16(out, words[i]);
  return out;
}

SymbolReader::SymbolReader(const Model& model, int set, ByteSpan segment, std::int64_t symbol_count,
                           int low_shift)
    : slots(model.tables.slots[static_cast<std::size_t>(set)].data()->data()), shift(low_shift) {
  const std::uint64_t plain_bytes = take_varint(segment);
  const ByteSpan plain_span = take_bytes(segment, plain_bytes);
  const auto state_total = static_cast<std::size_t>(state_count(symbol_count));
  state_mask = state_total - 1;
  const ByteSpan heads = take_bytes(segment, 4 * state_total);
  for (std::size_t i = 0; i < state_total; ++i) {
    for (std::size_t byte = 0; byte < 4; ++byte) {
      states[i] |= static_cast<std::uint32_t>(heads[4 * i + byte]) << (8 * byte);
    }
  }
  if (segment.size() % 2 != 0) throw Error(ErrorKind::corrupt, "a segment has half a word");
  // Every byte is set here: clearing them all first would cost as much again.
  padded_ = std::make_unique_for_overwrite<std::uint8_t[]>(segment.size() + kWordPadding +
                                                           plain_span.size() + kPlainPadding);
  const auto copy_padded = [](ByteSpan bytes, std::size_t padding, std::uint8_t* to) {
    std::fill_n(std::copy(bytes.begin(), bytes.end(), to), padding, std::uint8_t{0});
  };
  words = padded_.get();
  words_end = words + segment.size();
  copy_padded(segment, kWordPadding, padded_.get());
  std::uint8_t* const plain_copy = padded_.get() + segment.size() + kWordPadding;
  copy_padded(plain_span, kPlainPadding, plain_copy);
  plain = plain_copy;
  plain_end = 8 * plain_span.size();
}

void SymbolReader::finish() const {
  bool at_start = words == words_end && (plain_at + 7) / 8 == plain_end / 8;
  for (std::size_t i = 0; i <= state_mask; ++i) at_start = at_start && states[i] == kStateFloor;
  if (!at_start) throw Error(ErrorKind::corrupt, "a segment does not end where its symbols end");
}

void SymbolReader::fail_short() {
  throw Error(ErrorKind::corrupt, "a segment ends before its symbols do");
}

}  // namespace octavo::grey
