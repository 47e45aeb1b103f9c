#include "octavo/codec/grey/residual_coder.h"

#include <algorithm>

namespace octavo::grey {

namespace {

/// A symbol takes at most one word and so many plain bits, 16 of them for wide samples alone;
/// vectors read ahead by 16 bytes.
constexpr std::size_t kMaxSymbolBits = kEscapeBits + kMaxPlainBits + 16;
constexpr std::size_t kWordPadding = kMaxUnchecked * 2 + 32;
constexpr std::size_t kPlainPadding = kMaxUnchecked * kMaxSymbolBits / 8 + 32;

/// Values that will all be written: clearing them first would cost as much again.
template <class T>
std::unique_ptr<T[]> unset_array(std::size_t count) {
  return std::unique_ptr<T[]>(new T[count]);
}

std::uint8_t* put_little(std::uint8_t* to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) *to++ = static_cast<std::uint8_t>(value >> 8 * i);
  return to;
}

/// Bits to memory that has 8 bytes to spare, lowest bit first.
class PlainWriter {
 public:
  explicit PlainWriter(std::uint8_t* to) : to_(to) {}
  /// At most 56 bits.
  void put(std::uint64_t value, int count) {
    pending_ |= value << used_;
    used_ += count;
    if constexpr (std::endian::native == std::endian::little) std::memcpy(to_, &pending_, 8);
    else put_little(to_, pending_, 8);
    to_ += used_ >> 3;
    pending_ >>= used_ & ~7;
    used_ &= 7;
  }
  std::uint8_t* end() const { return to_ + (used_ > 0 ? 1 : 0); }

 private:
  std::uint8_t* to_;
  std::uint64_t pending_ = 0;
  int used_ = 0;
};

/// Splits symbols into tokens and plain bits; gives the end of the plain bits. Tokens without a
/// slot go through the escape token.
std::uint8_t* split_symbols(std::span<const std::uint64_t> used, const std::vector<Symbol>& symbols,
                            int shift, std::uint8_t* tokens, std::uint8_t* plain) {
  PlainWriter bits(plain);
  for (const Symbol& symbol : symbols) {
    const std::uint64_t value = symbol.value();
    const int low = symbol.low_bits() + (symbol.context() < kContexts ? shift : 0);
    int token = token_of(static_cast<std::uint32_t>(value >> low));
    if ((used[symbol.context()] >> token & 1) == 0) token = kEscapeToken;
    *tokens++ = static_cast<std::uint8_t>(token);
    const int count = token_shape(token).bits + low;
    bits.put(value & ((std::uint64_t{1} << count) - 1), count);
  }
  return bits.end();
}

/// Pushes tokens onto the states, last one first; words grow downwards from `end`. Gives the first
/// word.
std::uint16_t* push_tokens(std::span<const Encoder> encoders, const std::vector<Symbol>& symbols,
                           const std::uint8_t* tokens, std::uint32_t* states,
                           std::size_t state_mask, std::uint16_t* end) {
  for (std::size_t i = symbols.size(); i-- > 0;) {
    const Symbol& symbol = symbols[i];
    const Encoder& e = encoders[encoder_place(symbol.context(), tokens[i])];
    std::uint32_t& state = states[symbol.state() & state_mask];
    std::uint32_t x = state;
    // Without a branch: whether a word leaves is anyone's guess.
    const bool is_full = x >> (32 - kTableBits) >= e.frequency;
    end[-1] = static_cast<std::uint16_t>(x);
    end -= is_full;
    x >>= is_full ? 16 : 0;
    state = e.pushed(x);
  }
  return end;
}

}  // namespace

Bytes encode_symbols(const Model& model, int set, const std::vector<Symbol>& symbols,
                     std::int64_t details, int shift, int most_states) {
  if (symbols.empty()) return {};
  const std::span<const Encoder> encoders = model.tables.encoders[static_cast<std::size_t>(set)];
  const std::span<const std::uint64_t> used = model.tables.used[static_cast<std::size_t>(set)];
  const std::size_t count = symbols.size();
  const auto state_total = static_cast<std::size_t>(std::min(state_count(details), most_states));

  // Plain bits forwards, tokens backwards: rANS is a stack.
  const auto tokens = unset_array<std::uint8_t>(count);
  const auto plain = unset_array<std::uint8_t>(count * kMaxSymbolBits / 8 + 16);
  const std::uint8_t* const plain_end =
      split_symbols(used, symbols, shift, tokens.get(), plain.get());
  std::array<std::uint32_t, kMaxStates> states;
  states.fill(kStateFloor);
  const auto words = unset_array<std::uint16_t>(count + 1);
  const std::uint16_t* const words_end = words.get() + count + 1;
  const std::uint16_t* word = push_tokens(encoders, symbols, tokens.get(), states.data(),
                                          state_total - 1, words.get() + count + 1);

  Bytes out;
  const auto plain_bytes = static_cast<std::size_t>(plain_end - plain.get());
  out.reserve(10 + plain_bytes + 4 * state_total +
              2 * static_cast<std::size_t>(words_end - word));
  put_varint(out, plain_bytes);
  out.insert(out.end(), plain.get(), plain.get() + plain_bytes);
  std::size_t at = out.size();
  out.resize(at + 4 * state_total + 2 * static_cast<std::size_t>(words_end - word));
  std::uint8_t* to = out.data() + at;
  for (std::size_t i = 0; i < state_total; ++i) to = put_little(to, states[i], 4);
  while (word != words_end) to = put_little(to, *word++, 2);
  return out;
}

SymbolReader::SymbolReader(const Model& model, int set, ByteSpan segment, std::int64_t details,
                           int low_shift, int most_states)
    : slots(model.tables.slots[static_cast<std::size_t>(set)].data()->data()),
      edge_starts(model.tables.edge_starts.data()),
      shift(low_shift) {
  ByteSpan plain_span;
  if (details == 0) {
    states[0] = kStateFloor;
    if (!segment.empty()) throw Error(ErrorKind::corrupt, "a segment without symbols is not empty");
  } else {
    const std::uint64_t plain_bytes = take_varint(segment);
    plain_span = take_bytes(segment, plain_bytes);
    const auto state_total =
        static_cast<std::size_t>(std::min(state_count(details), most_states));
    state_mask = state_total - 1;
    const ByteSpan heads = take_bytes(segment, 4 * state_total);
    for (std::size_t i = 0; i < state_total; ++i) {
      for (std::size_t byte = 0; byte < 4; ++byte) {
        states[i] |= static_cast<std::uint32_t>(heads[4 * i + byte]) << (8 * byte);
      }
      if (states[i] < kStateFloor) {
        throw Error(ErrorKind::corrupt, "a state of a segment is too small");
      }
    }
    if (segment.size() % 2 != 0) throw Error(ErrorKind::corrupt, "a segment has half a word");
  }
  padded_ = unset_array<std::uint8_t>(segment.size() + kWordPadding + plain_span.size() +
                                      kPlainPadding);
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
