#include "octavo/render/rays/seen_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <span>
#include <vector>

#include "octavo/render/rays/ray_job.h"

namespace octavo {
namespace {

/// Seen from 100 to 200 and from 300.5 on.
bool is_seen_in_two(float lowest, float highest) {
  return (lowest <= 200 && highest >= 100) || highest >= 300.5f;
}

TEST(UnseenRanges, EndRightBeforeWhatIsSeen) {
  const auto ranges = unseen_ranges({-1000, 3000}, 1 / 16.0f, is_seen_in_two);
  ASSERT_EQ(ranges.size(), 2u);
  EXPECT_EQ(ranges[0].first, -1000);
  EXPECT_NEAR(ranges[0].last, 100 - 1 / 16.0, 1e-3);
  EXPECT_LT(ranges[0].last, 100 - 1 / 16.0);
  EXPECT_NEAR(ranges[1].first, 200 + 1 / 16.0, 1e-3);
  EXPECT_GT(ranges[1].first, 200 + 1 / 16.0);
  EXPECT_NEAR(ranges[1].last, 300.5 - 1 / 16.0, 1e-3);
  EXPECT_LT(ranges[1].last, 300.5 - 1 / 16.0);
}

TEST(UnseenRanges, AreOneWhereNothingIsSeenAndNoneWhereEverythingIs) {
  const auto all = unseen_ranges({-5, 7}, 0.1f, [](float, float) { return false; });
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].first, -5);
  EXPECT_EQ(all[0].last, 7);
  EXPECT_TRUE(unseen_ranges({-5, 7}, 0.1f, [](float, float) { return true; }).empty());
  EXPECT_TRUE(unseen_ranges({1, 0}, 0.1f, [](float, float) { return false; }).empty());
  EXPECT_EQ(unseen_ranges({3, 3}, 0.1f, [](float, float) { return false; }).size(), 1u);
}

TEST(UnseenRanges, AreAtMostEight) {
  // Every second stripe is seen.
  const auto is_seen = [](float lowest, float highest) {
    for (int stripe = 0; stripe < 50; ++stripe) {
      const float begin = 20.0f * static_cast<float>(stripe);
      if (lowest < begin + 10 && highest > begin) return true;
    }
    return false;
  };
  const auto ranges = unseen_ranges({0, 1000}, 0.01f, is_seen);
  EXPECT_EQ(ranges.size(), 8u);
  for (const UnseenRange& range : ranges) EXPECT_FALSE(is_seen(range.first, range.last));
}

/// Bits of a brick with neighbors of one sample on its high sides, and what they have to be.
template <class Pooled>
void compare_bits(int shift, const std::vector<UnseenRange>& ranges,
                  const std::vector<float>& cubes, std::uint32_t seed) {
  const int side = 1 << shift;
  const int row = side + 3;
  std::mt19937 random(seed);
  std::vector<Pooled> samples(static_cast<std::size_t>(row * row * row));
  const auto number = [&](int x, int y, int z) {
    return static_cast<std::size_t>((z * row + y) * row + x);
  };
  // Flat but for some of them, so that there are empty boxes.
  for (Pooled& sample : samples) {
    sample = static_cast<Pooled>(random() % 150 == 0 ? 60 : 10 + random() % 3);
  }
  for (int z = side / 2; z < row; ++z) {
    for (int x = 0; x < row; ++x) samples[number(x, 5, z)] = 90;
  }
  const auto is_empty = [&](int x, int y, int z) {
    const int cubes_along = side >> kSkipShift;
    const auto cube = static_cast<std::size_t>(
        ((z >> kSkipShift) * cubes_along + (y >> kSkipShift)) * cubes_along + (x >> kSkipShift));
    if (!cubes.empty() && !(cubes[cube] > 0)) return true;
    return std::any_of(ranges.begin(), ranges.end(), [&](const UnseenRange& range) {
      for (int corner = 0; corner < 8; ++corner) {
        const Pooled value =
            samples[number(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2))];
        if (static_cast<float>(value) < range.first || static_cast<float>(value) > range.last) {
          return false;
        }
      }
      return true;
    });
  };
  const auto is_box_seen = [&](int x, int y, int z) {
    for (int k = z; k < std::min(z + kSeenSide, side); ++k) {
      for (int j = y; j < std::min(y + kSeenSide, side); ++j) {
        if (!is_empty(x, j, k)) return true;
      }
    }
    return false;
  };
  std::vector<std::uint8_t> bytes(seen_bytes(shift), 0x5a);
  SeenBrick<Pooled> brick;
  brick.samples = samples.data();
  brick.row = row;
  brick.plane = row * row;
  brick.shift = shift;
  if (!cubes.empty()) brick.cube_bounds = cubes.data();
  mark_seen_cells(brick, ranges, bytes.data());
  int seen = 0;
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const auto bit = static_cast<std::size_t>((z * side + y) * side + x);
        const bool is_set = (bytes[bit / 8] >> bit % 8 & 1) != 0;
        ASSERT_EQ(is_set, is_box_seen(x, y, z)) << x << ' ' << y << ' ' << z;
        seen += is_set ? 1 : 0;
      }
    }
  }
  EXPECT_GT(seen, 0);
  if (!ranges.empty()) {
    EXPECT_LT(seen, side * side * side);
  }
}

TEST(SeenCells, AreThoseWithASampleInNoRange) {
  const std::vector<UnseenRange> ranges = {{-5.5f, 30.5f}};
  compare_bits<std::int16_t>(3, ranges, {}, 1);
  compare_bits<std::int16_t>(4, ranges, {}, 2);
  compare_bits<std::int16_t>(5, ranges, {}, 3);
  compare_bits<float>(4, ranges, {}, 4);
  compare_bits<std::int16_t>(3, {}, {}, 5);
}

TEST(SeenCells, AreThoseBetweenTwoRanges) {
  // Samples of 10, 11 and 12, 60 and 90: no range holds 12 and 60.
  const std::vector<UnseenRange> ranges = {{0, 12.4f}, {59.5f, 61}, {80, 100}};
  compare_bits<std::int16_t>(4, ranges, {}, 6);
  compare_bits<float>(3, ranges, {}, 7);
}

/// How many bits are set in a brick of one value but for one sample.
int bits_around(std::int16_t value, std::int16_t other, const UnseenRange& range) {
  constexpr int kSide = 8;
  constexpr int kRow = kSide + 1;
  std::vector<std::int16_t> samples(kRow * kRow * kRow, value);
  samples[(4 * kRow + 4) * kRow + 4] = other;
  std::vector<std::uint8_t> bytes(seen_bytes(3));
  mark_seen_cells(SeenBrick<std::int16_t>{samples.data(), kRow, kRow * kRow, 3, nullptr},
                  std::span(&range, 1), bytes.data());
  int set = 0;
  for (const std::uint8_t byte : bytes) set += std::popcount(byte);
  return set;
}

TEST(SeenCells, RoundEndsOfRangesInwards) {
  // Two cells along x, and one before them along y and z besides.
  EXPECT_EQ(bits_around(-1, 0, {-5, -0.5f}), 2 * 3 * 3);
  EXPECT_EQ(bits_around(1, 0, {0.5f, 5}), 2 * 3 * 3);
  EXPECT_EQ(bits_around(1, 0, {0, 5}), 0);
}

TEST(SeenCells, AreNoneInEmptyCubes) {
  std::vector<float> cubes(64);
  for (std::size_t i = 0; i < cubes.size(); ++i) cubes[i] = i % 3 == 0 ? 1.0f : 0.0f;
  compare_bits<std::int16_t>(4, {{0, 30}}, cubes, 10);
  compare_bits<float>(4, {{0, 30}, {50, 100}}, cubes, 11);
}

}  // namespace
}  // namespace octavo
