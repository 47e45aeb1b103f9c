#include "octavo/file/storage/byte_range.h"

#include <algorithm>
#include <numeric>

namespace octavo {

namespace {

/// Joins each range to the one before where is_joined(i) says so, or where they overlap or touch.
/// Requires rising offsets, which they keep
template <class IsJoined>
void join_where(std::vector<ByteRange>& ranges, IsJoined is_joined) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const ByteRange range = ranges[i];
    if (count > 0 && (range.offset <= ranges[count - 1].end() || is_joined(i))) {
      ByteRange& last = ranges[count - 1];
      last.length = std::max(last.end(), range.end()) - last.offset;
    } else {
      ranges[count++] = range;
    }
  }
  ranges.resize(count);
}

/// The bytes between a range and the one before.
std::uint64_t gap_before(std::span<const ByteRange> ranges, std::size_t i) {
  return ranges[i].offset - ranges[i - 1].end();
}

/// Which ranges are joined to the ones before because they are too many.
/// spare_bytes  that gaps may have in all
std::vector<bool> excess_of(std::span<const ByteRange> ranges, const JoinLimits& limits,
                            std::uint64_t spare_bytes) {
  std::vector<bool> is_joined(ranges.size());
  const std::size_t most = std::max<std::size_t>(limits.most_ranges, 1);
  if (ranges.size() <= most) return is_joined;
  std::vector<std::size_t> by_gap(ranges.size() - 1);
  std::iota(by_gap.begin(), by_gap.end(), std::size_t{1});
  std::stable_sort(by_gap.begin(), by_gap.end(), [&](std::size_t a, std::size_t b) {
    return gap_before(ranges, a) < gap_before(ranges, b);
  });
  for (std::size_t i = 0; i < ranges.size() - most; ++i) {
    const std::uint64_t gap = gap_before(ranges, by_gap[i]);
    if (gap > limits.most_gap_bytes || gap > spare_bytes) break;
    spare_bytes -= gap;
    is_joined[by_gap[i]] = true;
  }
  return is_joined;
}

}  // namespace

std::vector<ByteRange> joined(std::vector<ByteRange> ranges, const JoinLimits& limits) {
  std::erase_if(ranges, [](const ByteRange& range) { return range.length == 0; });
  std::sort(ranges.begin(), ranges.end(),
            [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  join_where(ranges, [](std::size_t) { return false; });
  const std::uint64_t asked_bytes = total_bytes(ranges);
  std::vector<bool> is_joined(ranges.size());
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    is_joined[i] = gap_before(ranges, i) <= limits.gap_bytes;
  }
  join_where(ranges, [&](std::size_t i) { return is_joined[i]; });
  const std::uint64_t gap_bytes = total_bytes(ranges) - asked_bytes;
  const std::uint64_t most_bytes = asked_bytes + limits.spare_bytes;
  is_joined = excess_of(ranges, limits, most_bytes - std::min(gap_bytes, most_bytes));
  join_where(ranges, [&](std::size_t i) { return is_joined[i]; });
  return ranges;
}

std::uint64_t total_bytes(std::span<const ByteRange> ranges) {
  std::uint64_t sum = 0;
  for (const ByteRange& range : ranges) sum += range.length;
  return sum;
}

}  // namespace octavo
