// Which single bit of damaged bytes explains a wrong CRC-32C, how it is found, and when such a bit
// may be turned back.
//
// Each of n bits, flipped alone, changes the checksum to one of n values among 2^32. Other damage
// hits one of them by chance with odds of n / 2^32; turning back the bit that explains it then adds
// a wrong bit, and every checksum over those bytes matches. So a bit is turned back only where
// these odds, times those that the result gets past everything else that proves it, are small.
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

/// What proves damaged bytes besides their checksum, and those over the same bytes, which are no
/// other proof: a CRC is linear.
enum class OtherProof {
  none,
  range,     ///< numbers, as voxels that are stored: a wrong one is noticed outside its range alone
  content,   ///< decoding or parsing fails with most other bytes
  checksums  ///< every number in them is compared with bytes that have checksums of their own
};

/// The most bits among which the one that explains a checksum is turned back: other damage passes
/// for it with odds of 2^-20; with those of 2^-12 times what decoding lets through, of which 1 in
/// 70 was measured where a few bits of a CT brick were changed.
inline constexpr std::uint64_t kMaxPlainBits = std::uint64_t{1} << 12;
inline constexpr std::uint64_t kMaxCodedBits = std::uint64_t{1} << 20;

/// Whether one flipped bit that explains the checksum of `length` bytes is taken for the damage.
bool is_safe_guess(std::uint64_t length, OtherProof proof) noexcept;

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
