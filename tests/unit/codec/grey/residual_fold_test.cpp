#include "octavo/codec/grey/residual_fold.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <vector>

namespace octavo::grey {
namespace {

TEST(ResidualFold, ResidualsOfSmallestZigzagNumbersStandForAllDetailsFromAnyPrediction) {
  for (int last = 0; last <= 24; ++last) {
    for (int from = 0; from <= last; ++from) {
      std::set<int> numbers;
      for (int to = 0; to <= last; ++to) {
        const int residual = folded(to, from, last);
        ASSERT_EQ(unfolded(residual, from, last), to) << from << " of " << last;
        numbers.insert(residual < 0 ? -2 * residual - 1 : 2 * residual);
      }
      ASSERT_EQ(numbers.size(), static_cast<std::size_t>(last) + 1);
      ASSERT_EQ(*numbers.rbegin(), last) << from;
    }
  }
}

TEST(ResidualFold, DetailsNearerToTheMiddleComeFirstAndTheFarSideLast) {
  const auto order = [](int from, int last) {
    std::vector<int> numbers;
    for (const int residual : {0, -1, 1, -2, 2, -3, 3}) {
      numbers.push_back(unfolded(residual, from, last));
    }
    return numbers;
  };
  EXPECT_EQ(order(3, 6), (std::vector{3, 2, 4, 1, 5, 0, 6}));
  EXPECT_EQ(order(5, 6), (std::vector{5, 4, 6, 3, 2, 1, 0}));
  EXPECT_EQ(order(1, 6), (std::vector{1, 2, 0, 3, 4, 5, 6}));
  EXPECT_EQ(order(0, 6), (std::vector{0, 1, 2, 3, 4, 5, 6}));
}

TEST(ResidualFold, DamagedResidualsStandForADetailWithinTheLimit) {
  for (const std::int32_t residual : {-(1 << 28), -11, 11, 1 << 28}) {
    EXPECT_EQ(detail_of<std::int32_t>(residual, 3, 5), -5);
    EXPECT_EQ(detail_of<std::int32_t>(residual, -3, 5), 5);
    EXPECT_EQ(detail_of<std::int32_t>(residual, 0, 0), 0);
  }
}

TEST(ResidualFold, WidestDetailsComeBack) {
  const std::int64_t limit = std::int64_t{1} << 32;
  for (const std::int64_t prediction : {-limit, std::int64_t{-7}, std::int64_t{0}, limit}) {
    for (const std::int64_t detail : {-limit, std::int64_t{-1}, std::int64_t{2}, limit}) {
      EXPECT_EQ(detail_of(residual_of(detail, prediction, limit), prediction, limit), detail);
    }
  }
}

}  // namespace
}  // namespace octavo::grey
