#include "octavo/file/fixed_png.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace octavo {

namespace {

constexpr std::size_t kShortestMatch = 3;
constexpr std::size_t kLongestMatch = 258;

// CRC-32 of PNG: polynomial 0x04c11db7, reflected.
std::uint32_t png_crc(ByteSpan bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320u : 0);
  }
  return ~crc;
}

std::uint32_t adler32(ByteSpan bytes) {
  constexpr std::uint32_t kModulus = 65521;
  std::uint32_t sum = 1;
  std::uint32_t sum_of_sums = 0;
  for (const std::uint8_t byte : bytes) {
    sum = (sum + byte) % kModulus;
    sum_of_sums = (sum_of_sums + sum) % kModulus;
  }
  return sum_of_sums << 16 | sum;
}

void put_big_endian(Bytes& out, std::uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) {
    out.push_back(static_cast<std::uint8_t>(number >> shift));
  }
}

void put_chunk(Bytes& out, std::string_view name, ByteSpan data) {
  put_big_endian(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = out.size();
  out.insert(out.end(), name.begin(), name.end());
  out.insert(out.end(), data.begin(), data.end());
  put_big_endian(out, png_crc(ByteSpan(out).subspan(begin)));
}

// The symbols of deflate with its fixed codes (RFC 1951, 3.2.6).
class FixedCodes {
 public:
  explicit FixedCodes(Bytes& out) : out_(out) {}

  void put_bits(std::uint32_t bits, int count) {
    waiting_ |= bits << waiting_count_;
    for (waiting_count_ += count; waiting_count_ >= 8; waiting_count_ -= 8) {
      out_.push_back(static_cast<std::uint8_t>(waiting_));
      waiting_ >>= 8;
    }
  }

  // A byte, the end (256), or a length (257 and more).
  void put_symbol(std::uint32_t symbol) {
    if (symbol < 144) return put_code(0x30 + symbol, 8);
    if (symbol < 256) return put_code(0x190 + symbol - 144, 9);
    if (symbol < 280) return put_code(symbol - 256, 7);
    put_code(0xc0 + symbol - 280, 8);
  }

  void put_match(std::size_t length, std::size_t distance) {
    const auto rest = static_cast<std::uint32_t>(length - kShortestMatch);
    if (length == kLongestMatch) {
      put_symbol(285);
    } else {
      const int extra = extra_bits(rest, 3);
      put_symbol(257 + 4 * static_cast<std::uint32_t>(extra) + (rest >> extra));
      put_bits(rest & ((1u << extra) - 1), extra);
    }
    const auto behind = static_cast<std::uint32_t>(distance - 1);
    const int extra = extra_bits(behind, 2);
    put_code(2 * static_cast<std::uint32_t>(extra) + (behind >> extra), 5);
    put_bits(behind & ((1u << extra) - 1), extra);
  }

  void end() {
    put_symbol(256);
    if (waiting_count_ > 0) put_bits(0, 8 - waiting_count_);
  }

 private:
  // How many bits of a number follow behind the code that tells its `kept` highest ones.
  static int extra_bits(std::uint32_t number, int kept) {
    int extra = 0;
    while (number >> extra >> kept != 0) ++extra;
    return extra;
  }

  // Codes begin with their highest bit, everything else with its lowest.
  void put_code(std::uint32_t code, int length) {
    for (int bit = length - 1; bit >= 0; --bit) put_bits(code >> bit & 1, 1);
  }

  Bytes& out_;
  std::uint32_t waiting_ = 0;
  int waiting_count_ = 0;
};

// How many bytes from `at` on are those that stand `distance` before them.
std::size_t match_length(ByteSpan bytes, std::size_t at, std::size_t distance) {
  if (at < distance) return 0;
  const std::size_t most = std::min(kLongestMatch, bytes.size() - at);
  std::size_t length = 0;
  while (length < most && bytes[at + length] == bytes[at + length - distance]) ++length;
  return length;
}

void deflate_fixed(ByteSpan bytes, const std::array<std::size_t, 2>& distances, Bytes& out) {
  FixedCodes codes(out);
  codes.put_bits(1, 1);  // the last block
  codes.put_bits(1, 2);  // with fixed codes
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t near = match_length(bytes, at, distances[0]);
    const std::size_t far = match_length(bytes, at, distances[1]);
    const std::size_t length = std::max(near, far);
    if (length < kShortestMatch) {
      codes.put_symbol(bytes[at++]);
      continue;
    }
    codes.put_match(length, near == length ? distances[0] : distances[1]);
    at += length;
  }
  codes.end();
}

}  // namespace

Bytes encode_fixed_png(const PngPixels& pixels) {
  // Rows, each behind the number of its filter: none
  const std::size_t row_bytes = pixels.width * pixels.channels;
  Bytes rows;
  rows.reserve(pixels.height * (row_bytes + 1));
  for (std::size_t row = 0; row < pixels.height; ++row) {
    rows.push_back(0);
    const auto begin = pixels.values.begin() + static_cast<std::ptrdiff_t>(row * row_bytes);
    rows.insert(rows.end(), begin, begin + static_cast<std::ptrdiff_t>(row_bytes));
  }

  // A stream of zlib
  Bytes data = {0x78, 0x01};
  deflate_fixed(rows, {pixels.channels, row_bytes + 1}, data);
  put_big_endian(data, adler32(rows));

  // Three chunks
  constexpr std::uint8_t kGrey = 0;
  constexpr std::uint8_t kColor = 2;
  Bytes header;
  put_big_endian(header, static_cast<std::uint32_t>(pixels.width));
  put_big_endian(header, static_cast<std::uint32_t>(pixels.height));
  const std::uint8_t color_type = pixels.channels == 1 ? kGrey : kColor;
  header.insert(header.end(), {8, color_type, 0, 0, 0});
  Bytes png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  put_chunk(png, "IHDR", header);
  put_chunk(png, "IDAT", data);
  put_chunk(png, "IEND", {});
  return png;
}

}  // namespace octavo
