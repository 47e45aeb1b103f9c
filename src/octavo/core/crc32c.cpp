#include "octavo/core/crc32c.h"

#include <array>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#elif defined(__aarch64__) && defined(__linux__)
#include <arm_acle.h>
#include <asm/hwcap.h>
#include <sys/auxv.h>
#define OCTAVO_CRC32C_ARM 1
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

constexpr std::size_t kStepBytes = 8;
using StepTables = std::array<std::array<std::uint32_t, 256>, kStepBytes>;

/// What a byte adds that 0 .. 7 others follow.
StepTables make_step_tables() noexcept {
  StepTables tables{};
  tables[0] = kTable;
  for (std::size_t k = 1; k < kStepBytes; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[k - 1][byte];
      tables[k][byte] = kTable[before & 0xff] ^ before >> 8;
    }
  }
  return tables;
}

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

// x^(8 * byte_count)
constexpr std::uint32_t shift_by(std::uint64_t byte_count) noexcept {
  std::uint32_t shift = kOne;
  for (std::uint32_t power = kByteShift; byte_count != 0; byte_count >>= 1) {
    if ((byte_count & 1) != 0) shift = multiplied(shift, power);
    power = multiplied(power, power);
  }
  return shift;
}

#if defined(__x86_64__)
#define OCTAVO_CRC32C_TARGET __attribute__((target("sse4.2")))
OCTAVO_CRC32C_TARGET std::uint32_t step(std::uint32_t crc, std::uint64_t word) noexcept {
  return static_cast<std::uint32_t>(_mm_crc32_u64(crc, word));
}
OCTAVO_CRC32C_TARGET std::uint32_t step(std::uint32_t crc, std::uint8_t byte) noexcept {
  return _mm_crc32_u8(crc, byte);
}
bool has_crc_instruction() noexcept { return __builtin_cpu_supports("sse4.2"); }
#elif defined(OCTAVO_CRC32C_ARM)
#define OCTAVO_CRC32C_TARGET __attribute__((target("+crc")))
OCTAVO_CRC32C_TARGET std::uint32_t step(std::uint32_t crc, std::uint64_t word) noexcept {
  return __crc32cd(crc, word);
}
OCTAVO_CRC32C_TARGET std::uint32_t step(std::uint32_t crc, std::uint8_t byte) noexcept {
  return __crc32cb(crc, byte);
}
bool has_crc_instruction() noexcept { return (getauxval(AT_HWCAP) & HWCAP_CRC32) != 0; }
#endif

#if defined(OCTAVO_CRC32C_TARGET)
std::uint64_t word_at(const std::uint8_t* p) noexcept {
  std::uint64_t word;
  std::memcpy(&word, p, sizeof word);
  return word;
}

// An instruction takes three cycles, and one can begin in each: three lanes keep them busy.
constexpr std::size_t kLaneBytes = 4096;
constexpr std::uint32_t kLaneShift = shift_by(kLaneBytes);

OCTAVO_CRC32C_TARGET std::uint32_t crc32c_by_instruction(std::span<const std::uint8_t> bytes,
                                                         std::uint32_t crc) noexcept {
  crc = ~crc;
  const std::uint8_t* p = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= 3 * kLaneBytes; left -= 3 * kLaneBytes, p += 3 * kLaneBytes) {
    std::uint32_t second = 0;
    std::uint32_t third = 0;
    for (std::size_t at = 0; at < kLaneBytes; at += 8) {
      crc = step(crc, word_at(p + at));
      second = step(second, word_at(p + kLaneBytes + at));
      third = step(third, word_at(p + 2 * kLaneBytes + at));
    }
    crc = multiplied(kLaneShift, multiplied(kLaneShift, crc) ^ second) ^ third;
  }
  for (; left >= 8; left -= 8, p += 8) crc = step(crc, word_at(p));
  for (; left > 0; --left, ++p) crc = step(crc, *p);
  return ~crc;
}
#endif

}  // namespace

std::uint32_t crc32c_portable(std::span<const std::uint8_t> bytes, std::uint32_t crc) noexcept {
  // Made once: in a program for browsers they would weigh more than the code that needs them.
  static const StepTables tables = make_step_tables();
  crc = ~crc;
  const std::uint8_t* p = bytes.data();
  std::size_t left = bytes.size();
  const auto word = [](const std::uint8_t* at) {
    return std::uint32_t{at[0]} | std::uint32_t{at[1]} << 8 | std::uint32_t{at[2]} << 16 |
           std::uint32_t{at[3]} << 24;
  };
  for (; left >= kStepBytes; left -= kStepBytes, p += kStepBytes) {
    const std::uint32_t low = crc ^ word(p);
    const std::uint32_t high = word(p + 4);
    crc = tables[7][low & 0xff] ^ tables[6][low >> 8 & 0xff] ^ tables[5][low >> 16 & 0xff] ^
          tables[4][low >> 24] ^ tables[3][high & 0xff] ^ tables[2][high >> 8 & 0xff] ^
          tables[1][high >> 16 & 0xff] ^ tables[0][high >> 24];
  }
  for (; left > 0; --left, ++p) crc = kTable[(crc ^ *p) & 0xff] ^ crc >> 8;
  return ~crc;
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) noexcept {
#if defined(OCTAVO_CRC32C_TARGET)
  static const bool has_instruction = has_crc_instruction();
  if (has_instruction) return crc32c_by_instruction(bytes, crc);
#endif
  return crc32c_portable(bytes, crc);
}

std::uint32_t crc32c_shift(std::uint64_t byte_count) noexcept { return shift_by(byte_count); }

std::uint32_t crc32c_joined(std::uint32_t first, std::uint32_t second,
                            std::uint32_t shift) noexcept {
  return multiplied(shift, first) ^ second;
}

}  // namespace octavo
