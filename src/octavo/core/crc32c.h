// CRC-32C (Castagnoli), RFC 3720 appendix B.4: detects all errors of up to 3 bits in 2^31 bits and
// every burst of up to 32 bits.
#pragma once

#include <cstdint>
#include <span>

namespace octavo {

/// The checksum of `bytes` continued from `crc` (0 to start). Uses the CPU's instruction where
/// there is one.
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) noexcept;

/// The same by table, on every machine.
std::uint32_t crc32c_portable(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0) noexcept;

/// The factor that moves a checksum across so many bytes behind it, for crc32c_joined.
/// O(log count)
std::uint32_t crc32c_shift(std::uint64_t byte_count) noexcept;

/// The checksum of bytes followed by others, from the checksums of both.
/// shift   crc32c_shift of the length of the second
/// Source  x^(8 * length) modulo the polynomial, as in zlib's crc32_combine
std::uint32_t crc32c_joined(std::uint32_t first, std::uint32_t second,
                            std::uint32_t shift) noexcept;

/// Whether the checksum of some bytes is the one stored with them. Fuzz builds (OCTAVO_FUZZING)
/// take every checksum for right, so that mutants reach what lies behind.
inline bool checksum_matches([[maybe_unused]] std::uint32_t found,
                             [[maybe_unused]] std::uint32_t stored) noexcept {
#if defined(OCTAVO_FUZZING)
  return true;
#else
  return found == stored;
#endif
}

}  // namespace octavo
