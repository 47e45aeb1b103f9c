// Small pieces of byte streams: LEB128 varints and little-endian bit fields, with proven bounds.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {

/// Appends `value`, 7 bits per byte, lowest first, the high bit set on all but the last byte.
inline void put_varint(std::vector<std::uint8_t>& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80));
  out.push_back(static_cast<std::uint8_t>(value));
}

/// Takes a varint off the front of `bytes`. Throws Error{corrupt} at the end of the bytes, above
/// 64 bits, or when fewer bytes would have held it.
inline std::uint64_t take_varint(std::span<const std::uint8_t>& bytes) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64; shift += 7) {
    if (bytes.empty()) throw Error(ErrorKind::corrupt, "a number ends early");
    const std::uint8_t byte = bytes.front();
    bytes = bytes.subspan(1);
    if (shift == 63 && byte > 1) break;
    value |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
    if (byte == 0 && shift > 0) throw Error(ErrorKind::corrupt, "a number is longer than needed");
    if (byte < 0x80) return value;
  }
  throw Error(ErrorKind::corrupt, "a number exceeds 64 bits");
}

/// Takes `count` bytes off the front of `bytes`. Throws Error{corrupt} when there are fewer.
inline std::span<const std::uint8_t> take_bytes(std::span<const std::uint8_t>& bytes,
                                                std::uint64_t count) {
  if (count > bytes.size()) throw Error(ErrorKind::corrupt, "a section ends early");
  const auto taken = bytes.first(static_cast<std::size_t>(count));
  bytes = bytes.subspan(static_cast<std::size_t>(count));
  return taken;
}

/// Appends the length of `bytes` as a varint, then the bytes.
inline void put_counted(std::vector<std::uint8_t>& out, std::span<const std::uint8_t> bytes) {
  put_varint(out, bytes.size());
  out.insert(out.end(), bytes.begin(), bytes.end());
}

/// Takes what put_counted wrote off the front of `bytes`. Throws Error{corrupt}.
inline std::span<const std::uint8_t> take_counted(std::span<const std::uint8_t>& bytes) {
  const std::uint64_t count = take_varint(bytes);
  return take_bytes(bytes, count);
}

/// Significant bits of a number; 0 for 0.
constexpr int bit_length(std::uint64_t value) {
  return value == 0 ? 0 : 64 - __builtin_clzll(value);
}

/// Maps 0, -1, 1, -2, ... to 0, 1, 2, 3, ...
constexpr std::uint64_t zigzag(std::int64_t value) {
  return static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63);
}
constexpr std::int64_t unzigzag(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

/// Packs fields of up to 56 bits, lowest bit first.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::uint8_t>& out) : out_(out) {}
  void put(std::uint64_t value, int count) {
    pending_ |= value << used_;
    for (used_ += count; used_ >= 8; used_ -= 8, pending_ >>= 8) {
      out_.push_back(static_cast<std::uint8_t>(pending_));
    }
  }
  /// Pads the last byte with zeros.
  void finish() {
    if (used_ > 0) out_.push_back(static_cast<std::uint8_t>(pending_));
    pending_ = 0;
    used_ = 0;
  }

 private:
  std::vector<std::uint8_t>& out_;
  std::uint64_t pending_ = 0;
  int used_ = 0;
};

/// Reads what BitWriter wrote; beyond the end it reads zeros, which `is_consumed` then shows.
class BitReader {
 public:
  explicit BitReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint64_t get(int count) {
    const std::size_t at = position_ >> 3;
    std::uint64_t word = 0;
    if (at + 8 <= bytes_.size()) {
      std::memcpy(&word, bytes_.data() + at, 8);
      if constexpr (std::endian::native == std::endian::big) word = __builtin_bswap64(word);
    } else {
      for (std::size_t i = 0; i < 8 && at + i < bytes_.size(); ++i) {
        word |= static_cast<std::uint64_t>(bytes_[at + i]) << (8 * i);
      }
    }
    word >>= position_ & 7;
    position_ += static_cast<std::size_t>(count);
    return word & ((std::uint64_t{1} << count) - 1);
  }

  /// True when the fields taken end in the last byte.
  bool is_consumed() const { return (position_ + 7) / 8 == bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
};

}  // namespace octavo
