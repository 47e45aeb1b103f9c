#include "octavo/ops/measure/exact_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cfloat>
#include <cmath>
#include <random>
#include <vector>

namespace octavo {
namespace {

ExactSum sum_of(const std::vector<float>& values) {
  ExactSum sum;
  for (const float value : values) sum.add(value);
  return sum;
}

/// Any finite floats, subnormal ones as well.
std::vector<float> any_floats(std::mt19937& random, std::size_t count) {
  std::vector<float> values;
  while (values.size() < count) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::isfinite(value)) values.push_back(value);
  }
  return values;
}

TEST(ExactSum, HasTheSameDigitsInAnyOrderAndAnyParts) {
  std::mt19937 random(1);
  std::vector<float> values = any_floats(random, 3000);
  const ExactSum whole = sum_of(values);
  for (int round = 0; round < 5; ++round) {
    std::shuffle(values.begin(), values.end(), random);
    ExactSum joined;
    for (auto begin = values.begin(); begin != values.end();) {
      const auto left = static_cast<std::size_t>(values.end() - begin);
      const auto end = begin + static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                                   left, 1 + random() % 900));
      const ExactSum part = sum_of({begin, end});
      joined.add(ExactSum(part.normal_sum(), part.normal_squares()));
      begin = end;
    }
    EXPECT_EQ(joined.normal_sum(), whole.normal_sum());
    EXPECT_EQ(joined.normal_squares(), whole.normal_squares());
    EXPECT_EQ(joined.sum(), whole.sum());
    EXPECT_EQ(joined.squared_distances(values.size()), whole.squared_distances(values.size()));
  }
}

/// Whole numbers, whose sums a 64-bit integer holds.
TEST(ExactSum, IsTheSum) {
  std::mt19937 random(2);
  for (const float scale : {1.0f, std::ldexp(1.0f, -149), std::ldexp(1.0f, 100)}) {
    std::vector<float> values;
    std::int64_t sum = 0;
    std::int64_t squares = 0;
    for (int i = 0; i < 2000; ++i) {
      const std::int64_t value = static_cast<std::int64_t>(random() % 65537) - 40000;
      sum += value;
      squares += value * value;
      values.push_back(static_cast<float>(value) * scale);
    }
    const auto unit = static_cast<long double>(scale);
    const ExactSum found = sum_of(values);
    EXPECT_EQ(found.sum(), static_cast<long double>(sum) * unit);
    const std::int64_t distances = 2000 * squares - sum * sum;
    EXPECT_EQ(found.squared_distances(2000), static_cast<long double>(distances) * unit * unit);
  }
}

TEST(ExactSum, LosesNothingBesideTheLargestFloats) {
  const float smallest = std::ldexp(1.0f, -149);
  const ExactSum sum = sum_of({FLT_MAX, smallest, FLT_MAX, -FLT_MAX, -FLT_MAX});
  EXPECT_EQ(sum.sum(), static_cast<long double>(smallest));
  EXPECT_EQ(ExactSum().sum(), 0);
  EXPECT_EQ(ExactSum().squared_distances(0), 0);
  EXPECT_EQ(sum_of({-2.5f, -0.0f}).sum(), -2.5L);
}

/// A spread of one unit in the last place far from 0.
TEST(ExactSum, SeesASmallSpreadFarFromZero) {
  const float value = 16777215;
  const ExactSum sum = sum_of({value, value - 1, value, value - 1});
  EXPECT_EQ(sum.squared_distances(4), 4 * 4 * 0.25L);
}

}  // namespace
}  // namespace octavo
