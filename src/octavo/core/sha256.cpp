#include "octavo/core/sha256.h"

#include <algorithm>
#include <bit>

namespace octavo {

namespace {

// SHA-2 reads and writes numbers highest byte first.
std::uint32_t load_big_endian(const std::uint8_t* in) {
  return std::uint32_t{in[0]} << 24 | std::uint32_t{in[1]} << 16 | std::uint32_t{in[2]} << 8 |
         std::uint32_t{in[3]};
}

void store_big_endian(std::uint32_t value, std::uint8_t* out) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

}  // namespace

void Sha256::add_block(const std::uint8_t* block) noexcept {
  // The message schedule
  std::array<std::uint32_t, 64> w;
  for (std::size_t t = 0; t < 16; ++t) w[t] = load_big_endian(block + 4 * t);
  for (std::size_t t = 16; t < w.size(); ++t) {
    const std::uint32_t a = w[t - 15];
    const std::uint32_t b = w[t - 2];
    const std::uint32_t s0 = std::rotr(a, 7) ^ std::rotr(a, 18) ^ a >> 3;
    const std::uint32_t s1 = std::rotr(b, 17) ^ std::rotr(b, 19) ^ b >> 10;
    w[t] = w[t - 16] + s0 + w[t - 7] + s1;
  }
  // 64 rounds
  auto [a, b, c, d, e, f, g, h] = state_;
  for (std::size_t t = 0; t < w.size(); ++t) {
    const std::uint32_t s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + s1 + ((e & f) ^ (~e & g)) + kSha256Rounds[t] + w[t];
    const std::uint32_t s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g;
    g = f;
    f = e;
    e = d + t1;
    d = c;
    c = b;
    b = a;
    a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> change = {a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < change.size(); ++i) state_[i] += change[i];
}

void Sha256::add(ByteSpan bytes) {
  while (!bytes.empty()) {
    const std::size_t held = byte_count_ % kBlockBytes;
    const std::size_t count = std::min(bytes.size(), kBlockBytes - held);
    byte_count_ += count;
    if (count == kBlockBytes) {
      add_block(bytes.data());
    } else {
      std::copy_n(bytes.begin(), count, rest_.begin() + static_cast<std::ptrdiff_t>(held));
      if (held + count == kBlockBytes) add_block(rest_.data());
    }
    bytes = bytes.subspan(count);
  }
}

Sha256Digest Sha256::digest() {
  // A one, zeros up to eight bytes before the end of a block, the number of bits
  const std::uint64_t bit_count = 8 * byte_count_;
  constexpr std::array<std::uint8_t, kBlockBytes> kPadding = {0x80};
  const std::size_t held = byte_count_ % kBlockBytes;
  add(ByteSpan(kPadding).first(held < 56 ? 56 - held : 120 - held));
  std::array<std::uint8_t, 8> length;
  store_big_endian(static_cast<std::uint32_t>(bit_count >> 32), length.data());
  store_big_endian(static_cast<std::uint32_t>(bit_count), length.data() + 4);
  add(length);

  Sha256Digest result;
  for (std::size_t i = 0; i < state_.size(); ++i) store_big_endian(state_[i], &result[4 * i]);
  *this = {};
  return result;
}

Sha256Digest sha256(ByteSpan bytes) {
  Sha256 hasher;
  hasher.add(bytes);
  return hasher.digest();
}

std::string hex_text(const Sha256Digest& digest) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t byte : digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace octavo
