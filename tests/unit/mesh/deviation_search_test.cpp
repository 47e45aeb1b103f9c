#include "octavo/mesh/deviation_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace octavo {
namespace {

/// What surfaces whose triangles fall with the square root of the deviation are tried.
struct Tried {
  std::vector<double> sums;
  double base = 0;
  std::uint64_t best_count = 0;

  explicit Tried(DeviationSearch& search, std::uint64_t fewest = 0) {
    while (const auto deviation = search.next()) {
      EXPECT_GT(*deviation, 0);
      const double sum = base + *deviation;
      sums.push_back(sum);
      const auto count =
          std::max(fewest, static_cast<std::uint64_t>(10000 / std::sqrt(sum)));
      const TrialFate fate = search.found(count);
      if (fate == TrialFate::base) base = sum;
      if (fate == TrialFate::best) best_count = count;
    }
  }
};

TEST(DeviationSearch, EndsAtTheFirstDeviationThatDoes) {
  DeviationSearch search(15000, 0.5, 1000);
  const Tried tried(search);
  EXPECT_EQ(tried.sums, std::vector<double>{0.5});
  EXPECT_EQ(search.best_deviation(), 0.5);
}

TEST(DeviationSearch, ComesNearTheLimitFromBelow) {
  for (const std::uint64_t limit : {14000u, 5000u, 1234u, 700u}) {
    DeviationSearch search(limit, 0.5, 1000);
    const Tried tried(search);
    EXPECT_LE(tried.best_count, limit);
    EXPECT_GE(static_cast<double>(tried.best_count), 0.95 * static_cast<double>(limit));
    const double aim = 1e8 / (static_cast<double>(limit) * static_cast<double>(limit));
    EXPECT_NEAR(search.best_deviation().value(), aim, 0.1 * aim);
    EXPECT_LT(tried.sums.size(), 20u);
  }
}

TEST(DeviationSearch, SaysHowFewThereWereWhereThatIsTooMany) {
  DeviationSearch search(100, 0.5, 1000);
  const Tried tried(search, 400);
  EXPECT_FALSE(search.best_deviation());
  EXPECT_EQ(search.fewest(), 400u);
  EXPECT_LT(tried.sums.back(), 2600);
  DeviationSearch far(100, 0.5, 1000);
  EXPECT_GE(Tried(far).sums.back(), 1000);
  EXPECT_FALSE(far.best_deviation());
}

TEST(DeviationSearch, TakesTheNearestWhereCountsDoNotFallEvenly) {
  // More triangles than the limit up to a sum of 3, then far fewer.
  DeviationSearch search(1000, 0.5, 1000);
  double base = 0;
  double best = 0;
  while (const auto deviation = search.next()) {
    const double sum = base + *deviation;
    const double count = sum < 3 ? 1100 + 500 / sum : 100;
    const TrialFate fate = search.found(static_cast<std::uint64_t>(count));
    if (fate == TrialFate::base) base = sum;
    if (fate == TrialFate::best) best = sum;
  }
  EXPECT_GE(best, 3);
  EXPECT_LT(best, 4);
  EXPECT_EQ(search.best_deviation(), best);
}

}  // namespace
}  // namespace octavo
