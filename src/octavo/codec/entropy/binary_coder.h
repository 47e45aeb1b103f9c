// Binary arithmetic coding with probabilities given from outside (a carry-less view of the range
// coder of Martin 1979, in the byte-wise form with carry propagation that LZMA made common).
//
// The stream ends where the decoder's look-ahead ends: a decoder that has taken every decision has
// consumed exactly the bytes that the encoder wrote, which `is_consumed` proves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

/// Probability that a decision is 1, in units of 1/65536; 1 .. 65535.
using Probability = std::uint32_t;
inline constexpr Probability kEvenOdds = 1u << 15;

class BinaryEncoder {
 public:
  explicit BinaryEncoder(std::vector<std::uint8_t>& out) : out_(&out) {}

  [[gnu::always_inline]] void put(bool bit, Probability one) {
    const std::uint32_t bound = (range_ >> 16) * one;
    if (bit) {
      range_ = bound;
    } else {
      low_ += bound;
      range_ -= bound;
    }
    while (range_ < kTop) {
      range_ <<= 8;
      shift_low();
    }
  }

  /// `count` bits of `value`, highest first, at even odds.
  void put_bits(std::uint32_t value, int count) {
    while (count-- > 0) put(value >> count & 1, kEvenOdds);
  }

  /// As finish, but ends in as many zero bits as a decoder allows and drops zero bytes from the
  /// end, at most four: a decoder that has taken every decision is 0 to 4 bytes beyond the end.
  void finish_short() {
    const std::uint64_t last = low_ + range_ - 1;
    std::uint64_t mask = 0xffffffffffu;
    while ((last & ~mask) < low_) mask >>= 1;
    low_ = last & ~mask;
    finish();
    for (int i = 0; i < 4 && !out_->empty() && out_->back() == 0; ++i) out_->pop_back();
  }

  /// Writes what is still held back. Nothing may be put afterwards.
  void finish() {
    for (int i = 0; i < 5; ++i) shift_low();
  }

 private:
  static constexpr std::uint32_t kTop = 1u << 24;

  [[gnu::noinline]] void shift_low() {
    if (low_ < 0xff000000u || low_ > 0xffffffffu) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      // The very first byte is always 0 and is not written.
      if (has_first_) out_->push_back(static_cast<std::uint8_t>(cache_ + carry));
      has_first_ = true;
      for (; pending_ > 0; --pending_) out_->push_back(static_cast<std::uint8_t>(0xff + carry));
      cache_ = static_cast<std::uint8_t>(low_ >> 24);
    } else {
      ++pending_;
    }
    low_ = (low_ & 0x00ffffffu) << 8;
  }

  std::vector<std::uint8_t>* out_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffu;
  std::uint64_t pending_ = 0;
  std::uint8_t cache_ = 0;
  bool has_first_ = false;
};

class BinaryDecoder {
 public:
  /// Reads `bytes` from the start; beyond their end it reads zeros and remembers that it did.
  explicit BinaryDecoder(std::span<const std::uint8_t> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }

  bool get(Probability one) {
    const std::uint32_t bound = (range_ >> 16) * one;
    const bool bit = code_ < bound;
    if (bit) {
      range_ = bound;
    } else {
      code_ -= bound;
      range_ -= bound;
    }
    while (range_ < kTop) {
      range_ <<= 8;
      code_ = code_ << 8 | next();
    }
    return bit;
  }

  std::uint32_t get_bits(int count) {
    std::uint32_t value = 0;
    while (count-- > 0) value = value << 1 | static_cast<std::uint32_t>(get(kEvenOdds));
    return value;
  }

  /// Bytes taken so far, the look-ahead included.
  std::size_t consumed() const { return position_; }

  /// True when exactly all bytes were taken: neither too much nor too little.
  bool is_consumed() const { return position_ == bytes_.size(); }

  /// True when all bytes were taken and no more than finish_short may have dropped.
  bool is_consumed_short() const {
    return position_ >= bytes_.size() && position_ <= bytes_.size() + 4;
  }

  /// True when decisions were taken from bytes that are not there.
  bool is_overrun() const { return position_ > bytes_.size(); }

 private:
  static constexpr std::uint32_t kTop = 1u << 24;

  std::uint32_t next() {
    const std::size_t at = position_++;
    return at < bytes_.size() ? bytes_[at] : 0u;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  std::uint32_t range_ = 0xffffffffu;
  std::uint32_t code_ = 0;
};

/// A probability that learns from the decisions it codes: fast at first, then by 1/2^kRate.
template <int kRate>
class AdaptiveBitOf {
 public:
  AdaptiveBitOf() = default;
  explicit AdaptiveBitOf(Probability one) : one_(static_cast<std::uint16_t>(one)) {}

  Probability probability() const { return one_; }

  void update(bool bit) {
    const int rate = count_ < kRate ? count_ + 1 : kRate;
    if (count_ < kRate) ++count_;
    const int target = bit ? kCeiling : kFloor;
    one_ = static_cast<std::uint16_t>(one_ + (target - one_) / (1 << rate));
  }

 private:
  static constexpr int kFloor = 32;
  static constexpr int kCeiling = 65536 - 32;

  std::uint16_t one_ = kEvenOdds;
  std::uint8_t count_ = 0;
};

using AdaptiveBit = AdaptiveBitOf<5>;

template <int kRate>
void put_adaptive(BinaryEncoder& coder, AdaptiveBitOf<kRate>& model, bool bit) {
  coder.put(bit, model.probability());
  model.update(bit);
}

template <int kRate>
bool get_adaptive(BinaryDecoder& coder, AdaptiveBitOf<kRate>& model) {
  const bool bit = coder.get(model.probability());
  model.update(bit);
  return bit;
}

}  // namespace octavo
