// Ranges of the bytes of a file, and which of them are asked for together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace octavo {

struct ByteRange {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;

  bool operator==(const ByteRange&) const = default;
  std::uint64_t end() const { return offset + length; }
};

/// What lies between two ranges costs time to send, a request of its own costs time to answer.
struct JoinLimits {
  /// Bytes between two ranges that are always asked for along with them.
  std::uint64_t gap_bytes = std::uint64_t{1} << 15;
  /// Where more ranges than these are left, the smallest gaps are asked for along, too, ..
  std::size_t most_ranges = 15;
  /// .. but none that is larger, ..
  std::uint64_t most_gap_bytes = std::uint64_t{1} << 18;
  /// .. and all gaps together only as far as they are so much larger than the ranges.
  std::uint64_t spare_bytes = std::uint64_t{1} << 20;
};

/// Ranges stay apart unless they overlap or touch.
inline constexpr JoinLimits kNoGaps{0, std::numeric_limits<std::size_t>::max(), 0, 0};

/// The ranges that cover `ranges`, rising and apart from one another; empty ones are left out.
/// Complexity O(n log n)
std::vector<ByteRange> joined(std::vector<ByteRange> ranges, const JoinLimits& limits);

/// The sum of their lengths.
std::uint64_t total_bytes(std::span<const ByteRange> ranges);

}  // namespace octavo
