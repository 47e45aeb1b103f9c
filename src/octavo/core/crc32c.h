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
