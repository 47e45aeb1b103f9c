#include "octavo/file/storage/byte_range.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace octavo {
namespace {

using Ranges = std::vector<ByteRange>;

TEST(ByteRanges, ThoseThatOverlapOrTouchAreOne) {
  EXPECT_EQ(joined({{20, 5}, {0, 10}, {5, 10}, {15, 2}, {40, 0}, {21, 1}}, kNoGaps),
            (Ranges{{0, 17}, {20, 5}}));
  EXPECT_EQ(joined({}, kNoGaps), Ranges{});
  EXPECT_EQ(joined({{7, 0}}, {}), Ranges{});
}

TEST(ByteRanges, GapsUpToTheLimitAreClosed) {
  const Ranges apart{{0, 10}, {15, 5}, {26, 4}, {100, 1}};
  EXPECT_EQ(joined(apart, {5, 100, 0, 0}), (Ranges{{0, 20}, {26, 4}, {100, 1}}));
  EXPECT_EQ(joined(apart, {6, 100, 0, 0}), (Ranges{{0, 30}, {100, 1}}));
}

TEST(ByteRanges, BeyondTheMostTheSmallestGapsAreClosed) {
  const Ranges apart{{0, 40}, {45, 15}, {80, 20}, {156, 8}, {167, 2}};
  EXPECT_EQ(joined(apart, {0, 5, 1000, 0}), apart);
  EXPECT_EQ(joined(apart, {0, 4, 1000, 0}), (Ranges{{0, 40}, {45, 15}, {80, 20}, {156, 13}}));
  EXPECT_EQ(joined(apart, {0, 2, 1000, 0}), (Ranges{{0, 100}, {156, 13}}));
  EXPECT_EQ(joined(apart, {0, 1, 1000, 0}), (Ranges{{0, 169}}));
  EXPECT_EQ(joined(apart, {0, 0, 1000, 0}), (Ranges{{0, 169}}));
  // But none that is too large
  EXPECT_EQ(joined(apart, {0, 1, 20, 0}), (Ranges{{0, 100}, {156, 13}}));
  // .. nor so many that they double the bytes
  EXPECT_EQ(joined({{0, 10}, {15, 5}, {40, 4}, {100, 1}}, {0, 1, 1000, 0}),
            (Ranges{{0, 20}, {40, 4}, {100, 1}}));
  EXPECT_EQ(joined({{0, 10}, {20, 10}, {45, 1}}, {10, 1, 1000, 0}), (Ranges{{0, 30}, {45, 1}}));
  EXPECT_EQ(joined({{0, 10}, {20, 10}, {45, 1}}, {10, 1, 1000, 4}), (Ranges{{0, 46}}));
}

/// Against a set of bytes: what is covered, and which gaps are left.
TEST(ByteRanges, EveryByteIsCoveredAndNoGapIsClosedThatIsLarger) {
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    Ranges ranges;
    std::set<std::uint64_t> bytes;
    for (std::size_t i = random() % 12; i > 0; --i) {
      ranges.push_back({random() % 300, random() % 20});
      for (std::uint64_t at = ranges.back().offset; at < ranges.back().end(); ++at) {
        bytes.insert(at);
      }
    }
    const JoinLimits limits{random() % 10, 1 + random() % 6, 10 + random() % 30,
                            random() % 20};
    const Ranges found = joined(ranges, limits);
    std::uint64_t covered = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const auto first = bytes.lower_bound(found[i].offset);
      ASSERT_TRUE(first != bytes.end() && *first == found[i].offset);
      ASSERT_TRUE(bytes.count(found[i].end() - 1) != 0);
      std::uint64_t before = *first;
      for (auto at = first; at != bytes.end() && *at < found[i].end(); before = *at, ++at) {
        ++covered;
        ASSERT_LE(*at - before, limits.most_gap_bytes + 1);
      }
      if (i == 0) continue;
      const std::uint64_t gap = found[i].offset - found[i - 1].end();
      ASSERT_GT(gap, limits.gap_bytes);
      if (found.size() > limits.most_ranges && gap <= limits.most_gap_bytes) {
        ASSERT_GT(total_bytes(found) + gap, 2 * bytes.size() + limits.spare_bytes);
      }
    }
    ASSERT_EQ(covered, bytes.size());
    if (found.size() < joined(ranges, {limits.gap_bytes, 1000, 0, 0}).size()) {
      ASSERT_LE(total_bytes(found), 2 * covered + limits.spare_bytes);
    }
  }
}

}  // namespace
}  // namespace octavo
