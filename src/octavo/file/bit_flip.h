// Which single bit of a damaged run of bytes explains a wrong CRC-32C.
#pragma once

#include <cstdint>
#include <optional>

namespace octavo {

struct BitFlip {
  std::uint64_t byte = 0;  ///< position in the checked bytes
  int bit = 0;             ///< 0 = lowest
};

/// The one flipped bit among the last `length` bytes that were checksummed that turns `stored` into
/// `found`, or nothing when no single bit does.
/// Complexity  8 * length steps of a shift register: a CRC is linear, so the difference of two
/// checksums
///             is that of the difference of their messages, a single bit pushed on by what follows
///             it
std::optional<BitFlip> find_bit_flip(std::uint32_t found, std::uint32_t stored,
                                     std::uint64_t length) noexcept;

}  // namespace octavo
