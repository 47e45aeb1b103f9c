// Which single bit of a damaged run of bytes explains a wrong CRC-32C.
#pragma once

#include <cstdint>
#include <optional>

namespace octavo {

struct BitFlip {
  std::uint64_t byte = 0;  ///< position in the checked bytes
  int bit = 0;             ///< 0 = lowest
};

/// Flipped bits are looked for in at most this many bytes.
inline constexpr std::uint64_t kMaxSearchedBytes = std::uint64_t{16} << 20;

/// The one flipped bit among the last `length` bytes that were checksummed that turns `stored` into
/// `found`; nothing when no single bit does or `length` is above kMaxSearchedBytes.
/// Complexity  8 * length steps of a shift register: a CRC is linear, so two checksums differ by
///             what a single bit, pushed on by the bytes that follow it, becomes
std::optional<BitFlip> find_bit_flip(std::uint32_t found, std::uint32_t stored,
                                     std::uint64_t length) noexcept;

}  // namespace octavo
