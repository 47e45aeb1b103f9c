#include "octavo/codec/grey/residual_coder.h"

#include <algorithm>

namespace octavo::grey {

namespace {

/// A symbol takes at most one word and so many plain bits, 16 of them for wide samples alone;
/// vectors read ahead by 32 bytes.
constexpr std::size_t kMaxSymbolBits = kEscapeBits + kMaxPlainBits + 16;
constexpr std::size_t kWordPadding = kMaxUnchecked * 2 + 32;
constexpr std::size_t kPlainPadding = kMaxUnchecked * kMaxSymbolBits / 8 + 32;

std::uint8_t* put_little(std::uint8_t* to, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) *to++ = static_cast<std::uint8_t>(value >> 8 * i);
  return to;
}

/// Room for at least so much, and for as much as there ever was.
template <class T>
void grow(std::vector<T>& values, std::size_t count) {
  if (values.size() < count) values.resize(count);
}

}  // namespace

std::uint16_t* push_tokens(const TokenRun& run, std::uint32_t* states, std::size_t state_mask,
                           std::uint16_t* end) {
  for (std::size_t i = run.count; i-- > 0;) {
    const Encoder& e = run.encoders[run.places[i]];
    std::uint32_t& state = states[run.states[i] & state_mask];
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

SymbolWriter::SymbolWriter(const Model& model, int set, int shift, PushTokens push)
    : encoders_(model.tables.encoders[static_cast<std::size_t>(set)].data()),
      used_(model.tables.used[static_cast<std::size_t>(set)].data()),
      shift_(shift),
      push_(push),
      buffers_(thread_buffers()) {}

SymbolWriter::Buffers& SymbolWriter::thread_buffers() {
  // Kept from brick to brick: fresh memory costs more than filling it.
  static thread_local Buffers buffers;
  return buffers;
}

void SymbolWriter::make_room(std::size_t symbols) {
  grow(buffers_.places, count_ + symbols);
  grow(buffers_.states, count_ + symbols);
  grow(buffers_.plain, plain_at_ + symbols * kMaxSymbolBits / 8 + 16);
}

void SymbolWriter::add(std::span<const Symbol> symbols) {
  make_room(symbols.size());
  for (const Symbol& symbol : symbols) add(symbol);
}

/// A token without a slot goes through the escape token.
void SymbolWriter::add(const Symbol& symbol) {
  const std::uint64_t value = symbol.value();
  const std::size_t context = symbol.context();
  const int low = symbol.low_bits() + (context < kContexts ? shift_ : 0);
  int token = token_of(static_cast<std::uint32_t>(value >> low));
  if ((used_[context] >> token & 1) == 0) token = kEscapeToken;
  *next_places() =
      static_cast<std::uint16_t>(encoder_place(context, static_cast<std::size_t>(token)));
  *next_states() = static_cast<std::uint8_t>(symbol.state());
  const int count = token_shape(token).bits + low;
  keep(1, value & ((std::uint64_t{1} << count) - 1), count);
}

Bytes SymbolWriter::finish(std::int64_t details, int most_states) {
  if (count_ == 0) return {};
  const auto state_total = static_cast<std::size_t>(std::min(state_count(details), most_states));
  const std::size_t plain_bytes = plain_at_ + (pending_count_ > 0 ? 1 : 0);
  // Backwards: rANS is a stack.
  alignas(64) std::array<std::uint32_t, kMaxStates> states;
  states.fill(kStateFloor);
  grow(buffers_.words, kSpareWords + count_);
  std::uint16_t* const words_end = buffers_.words.data() + kSpareWords + count_;
  const std::uint16_t* word =
      push_({encoders_, buffers_.places.data(), buffers_.states.data(), count_}, states.data(),
            state_total - 1, words_end);

  Bytes out;
  const std::size_t tail_bytes = 4 * state_total + 2 * static_cast<std::size_t>(words_end - word);
  out.reserve(10 + plain_bytes + tail_bytes);
  put_varint(out, plain_bytes);
  out.insert(out.end(), buffers_.plain.data(), buffers_.plain.data() + plain_bytes);
  const std::size_t at = out.size();
  out.resize(at + tail_bytes);
  std::uint8_t* to = out.data() + at;
  for (std::size_t i = 0; i < state_total; ++i) to = put_little(to, states[i], 4);
  while (word != words_end) to = put_little(to, *word++, 2);
  return out;
}

Bytes encode_symbols(const Model& model, int set, std::span<const Symbol> symbols,
                     std::int64_t details, int shift, int most_states, PushTokens push) {
  SymbolWriter writer(model, set, shift, push);
  writer.add(symbols);
  return writer.finish(details, most_states);
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
  padded_->resize(segment.size() + kWordPadding + plain_span.size() + kPlainPadding);
  auto* const padded = reinterpret_cast<std::uint8_t*>(padded_->data());
  const auto copy_padded = [](ByteSpan bytes, std::size_t padding, std::uint8_t* to) {
    std::fill_n(std::copy(bytes.begin(), bytes.end(), to), padding, std::uint8_t{0});
  };
  words = padded;
  words_end = words + segment.size();
  copy_padded(segment, kWordPadding, padded);
  std::uint8_t* const plain_copy = padded + segment.size() + kWordPadding;
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
