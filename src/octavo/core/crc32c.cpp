#include "octavo/core/crc32c.h"

#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace octavo {

namespace {

constexpr std::uint32_t kReversedPolynomial = 0x82f63b78u;

consteval std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? kReversedPolynomial : 0u);
    table[byte] = crc;
  }
  return table;
}

constexpr std::array<std::uint32_t, 256> kTable = make_table();

#if defined(__x86_64__)
__attribute__((target("sse4.2"))) std::uint32_t crc32c_sse42(std::span<const std::uint8_t> bytes,
                                                             std::uint32_t crc) noexcept {
  std::uint64_t state = ~crc;
  const std::uint8_t* p = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 8; left -= 8, p += 8) {
    std::uint64_t word;
    std::memcpy(&word, p, 8);
    state = _mm_crc32_u64(state, word);
  }
  auto tail = static_cast<std::uint32_t>(state);
  for (; left > 0; --left, ++p) tail = _mm_crc32_u8(tail, *p);
  return ~tail;
}
#endif

// The product of two polynomials modulo that of the checksum; the highest bit is that of x^0.
constexpr std::uint32_t multiplied(std::uint32_t a, std::uint32_t b) noexcept {
  std::uint32_t product = 0;
  for (std::uint32_t bit = std::uint32_t{1} << 31; bit != 0; bit >>= 1) {
    if ((a & bit) != 0) product ^= b;
    b = b >> 1 ^ (b & 1 ? kReversedPolynomial : 0u);
  }
  return product;
}

constexpr std::uint32_t kOne = std::uint32_t{1} << 31;  // x^0
constexpr std::uint32_t kByteShift = kOne >> 8;         // x^8

}  // namespace

std::uint32_t crc32c_portable(std::span<const std::uint8_t> bytes, std::uint32_t crc) noexcept {
  crc = ~crc;
  for (const std::uint8_t byte : bytes) crc = kTable[(crc ^ byte) & 0xff] ^ crc >> 8;
  return ~crc;
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) noexcept {
#if defined(__x86_64__)
  static const bool has_instruction = __builtin_cpu_supports("sse4.2");
  if (has_instruction) return crc32c_sse42(bytes, crc);
#endif
  return crc32c_portable(bytes, crc);
}

std::uint32_t crc32c_shift(std::uint64_t byte_count) noexcept {
  std::uint32_t shift = kOne;
  for (std::uint32_t power = kByteShift; byte_count != 0; byte_count >>= 1) {
    if ((byte_count & 1) != 0) shift = multiplied(shift, power);
    power = multiplied(power, power);
  }
  return shift;
}

std::uint32_t crc32c_joined(std::uint32_t first, std::uint32_t second,
                            std::uint32_t shift) noexcept {
  return multiplied(shift, first) ^ second;
}

}  // namespace octavo
