#include "octavo/file/storage/byte_range.h"

#include <algorithm>

namespace octavo {

namespace {

/// Joins rising ranges that are not further apart than a gap. Ranges stay rising.
void join_gaps(std::vector<ByteRange>& ranges, std::uint64_t gap_bytes) {
  std::size_t count = 0;
  for (const ByteRange& range : ranges) {
    if (range.length == 0) continue;
    ByteRange* const last = count > 0 ? &ranges[count - 1] : nullptr;
    if (last != nullptr && (range.offset <= last->end() ||
                            range.offset - last->end() <= gap_bytes)) {
      last->length = std::max(last->end(), range.end()) - last->offset;
    } else {
      ranges[count++] = range;
    }
  }
  ranges.resize(count);
}

/// The size of gap up to which ranges that are apart are joined so that `most` are left.
std::uint64_t gap_that_leaves(std::span<const ByteRange> ranges, std::size_t most) {
  std::vector<std::uint64_t> gaps;
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    gaps.push_back(ranges[i].offset - ranges[i - 1].end());
  }
  const std::size_t joins = ranges.size() - std::max<std::size_t>(most, 1);
  const auto last = gaps.begin() + static_cast<std::ptrdiff_t>(joins - 1);
  std::nth_element(gaps.begin(), last, gaps.end());
  return *last;
}

}  // namespace

std::vector<ByteRange> joined(std::vector<ByteRange> ranges, const JoinLimits& limits) {
  std::sort(ranges.begin(), ranges.end(),
            [](const ByteRange& a, const ByteRange& b) { return a.offset < b.offset; });
  join_gaps(ranges, limits.gap_bytes);
  if (ranges.size() > std::max<std::size_t>(limits.most_ranges, 1)) {
    join_gaps(ranges, std::min(gap_that_leaves(ranges, limits.most_ranges),
                               limits.most_gap_bytes));
  }
  return ranges;
}

std::uint64_t total_bytes(std::span<const ByteRange> ranges) {
  std::uint64_t sum = 0;
  for (const ByteRange& range : ranges) sum += range.length;
  return sum;
}

}  // namespace octavo
