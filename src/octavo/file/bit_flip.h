// Which single bit of damaged bytes explains a wrong CRC-32C, and how that is told.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

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

/// Bytes of a file and the checksum kept for them.
struct CheckedBytes {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  /// Where the checksum itself stands, when nothing else vouches for it.
  std::optional<std::uint64_t> checksum_offset = {};
};

/// The one flipped bit that explains both checksums, in the bytes or in the checksum itself; its
/// `byte` is an offset in the file.
std::optional<BitFlip> locate_bit_flip(std::uint32_t found, std::uint32_t stored,
                                       const CheckedBytes& place) noexcept;

/// "checksum 9f3c1d22, stored 9f3c1d23", with " (one flipped bit, byte 83001)" where one explains
/// it.
std::string describe_checksums(std::uint32_t found, std::uint32_t stored,
                               const CheckedBytes& place);

}  // namespace octavo
