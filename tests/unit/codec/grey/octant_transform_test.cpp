#include "octavo/codec/grey/octant_transform.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace octavo {
namespace {

TEST(OctantTransform, PairIsRecoveredFromMeanAndDetailForBothRoundings) {
  for (int a = -40; a <= 40; ++a) {
    for (int b = -40; b <= 40; ++b) {
      for (const int rounding : {0, 1}) {
        const int mean = pair_mean(a, b, rounding);
        const Pair<int> pair = pair_of(mean, a - b, rounding);
        ASSERT_EQ(pair.a, a);
        ASSERT_EQ(pair.b, b);
      }
    }
  }
}

TEST(OctantTransform, ExtremesOf16BitsNeed17BitDetailsAndComeBack) {
  const std::int32_t detail = -32768 - 32767;
  EXPECT_EQ(detail, -65535);
  const Pair<std::int32_t> pair = pair_of(pair_mean(-32768, 32767, 1), detail, 1);
  EXPECT_EQ(pair.a, -32768);
  EXPECT_EQ(pair.b, 32767);
}

/// Every pair of weights that a volume of up to 40 voxels makes.
template <class F>
void for_each_weights(F&& f) {
  for (std::int64_t first = 1; first <= 32; first *= 2) {
    for (std::int64_t second = 1; second <= first; ++second) f(PairWeights{first, second});
  }
}

TEST(OctantTransform, PairOfTwoWeightsIsRecoveredFromMeanAndDetail) {
  for_each_weights([](const PairWeights& weights) {
    for (std::int64_t a = -40; a <= 40; ++a) {
      for (std::int64_t b = -40; b <= 40; ++b) {
        for (const int rounding : {0, 1}) {
          const std::int64_t mean = weighted_mean(a, b, weights, rounding);
          const auto pair = weighted_pair_of(mean, a - b, weights, rounding);
          ASSERT_EQ(pair.a, a);
          ASSERT_EQ(pair.b, b);
        }
      }
    }
  });
}

TEST(OctantTransform, MeanByWeightsIsTheNearestAndRoundsHalvesAsThePlainOneDoes) {
  for_each_weights([](const PairWeights& weights) {
    const std::int64_t sum = weights.first + weights.second;
    for (std::int64_t a = -40; a <= 40; ++a) {
      for (std::int64_t b = -40; b <= 40; ++b) {
        for (const int rounding : {0, 1}) {
          const std::int64_t mean = weighted_mean(a, b, weights, rounding);
          const std::int64_t above = 2 * (mean * sum - weights.first * a - weights.second * b);
          ASSERT_TRUE(rounding == 1 ? -sum < above && above <= sum : -sum <= above && above < sum)
              << weights.first << ":" << weights.second << " of " << a << " and " << b;
          if (weights.are_equal()) {
            ASSERT_EQ(mean, pair_mean(a, b, rounding));
          }
        }
      }
    }
  });
}

TEST(OctantTransform, WidestPairOfTheLargestWeightsComesBack) {
  const PairWeights weights{kMaxAxis / 2, kMaxAxis / 2 - 1};
  const std::int64_t low = std::numeric_limits<std::int32_t>::min();
  const std::int64_t high = std::numeric_limits<std::int32_t>::max();
  for (const auto& [a, b] : {Pair<std::int64_t>{low, high}, Pair<std::int64_t>{high, low}}) {
    const std::int64_t mean = weighted_mean(a, b, weights, 1);
    EXPECT_NEAR(static_cast<double>(mean), static_cast<double>(a + b) / 2, 2100);
    const auto pair = weighted_pair_of(mean, a - b, weights, 1);
    EXPECT_EQ(pair.a, a);
    EXPECT_EQ(pair.b, b);
  }
}

// Thesis 3.3: (9 7 3 5) has means 8 4 and half differences 1 -1, then mean 6 and half difference 2.
TEST(OctantTransform, ThesisExampleOfFourSamples) {
  const std::vector<std::int16_t> samples = {9, 7, 3, 5};
  const auto means = means_along(samples, {4, 1, 1}, 0, 0);
  EXPECT_EQ(means, (std::vector<std::int16_t>{8, 4}));
  EXPECT_EQ((samples[0] - samples[1]) / 2, 1);
  EXPECT_EQ((samples[2] - samples[3]) / 2, -1);
  const auto mean = means_along(means, {2, 1, 1}, 0, 0);
  EXPECT_EQ(mean, (std::vector<std::int16_t>{6}));
  EXPECT_EQ((means[0] - means[1]) / 2, 2);
}

TEST(OctantTransform, LoneSampleAtAnOddEdgeIsItsOwnMean) {
  const std::vector<std::int16_t> samples = {1, 2, 10, 4, 5, 20, 7, 8, 30};
  EXPECT_EQ(means_along(samples, {3, 3, 1}, 0, 0),
            (std::vector<std::int16_t>{1, 10, 4, 20, 7, 30}));
  EXPECT_EQ(means_along(samples, {3, 3, 1}, 1, 0), (std::vector<std::int16_t>{2, 3, 15, 7, 8, 30}));
}

TEST(OctantTransform, AxesOutsideTheMaskStay) {
  const std::vector<std::int16_t> samples = {1, 3, 5, 7};
  BrickShape shape;
  shape.size[0] = {2, 1, 2};
  shape.halving[0] = 1;
  EXPECT_EQ(coarser_level(samples, shape, 0), (std::vector<std::int16_t>{2, 6}));
}

/// Means over six levels of noise stay within 1.5 of the true mean and, where values spread over
/// more than a few integers, do not drift. (Noise of 0 and 1 has true means of 0.5 that no integer
/// meets.)
TEST(OctantTransform, MeansStayNearTheTrueMeanAtEveryLevel) {
  std::mt19937 random(7);
  for (const int amplitude : {1, 2, 3, 255, 40000}) {
    Size3 size{64, 64, 64};
    std::vector<std::int32_t> level(64 * 64 * 64);
    for (auto& v : level)
      v = static_cast<std::int32_t>(random() % static_cast<unsigned>(amplitude + 1));
    std::vector<double> exact(level.begin(), level.end());
    for (int k = 0; k < 6; ++k) {
      BrickShape shape;
      shape.size[0] = size;
      shape.halving[0] = kHalveAll;
      shape.weights.each = shape.weights.last = {1 << k, 1 << k, 1 << k};
      level = coarser_level(level, shape, 0);
      const Size3 half = halved(size, kHalveAll);
      std::vector<double> means(level.size());
      for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
        const std::int64_t x = i % size.x, y = i / size.x % size.y, z = i / (size.x * size.y);
        means[static_cast<std::size_t>((z / 2 * half.y + y / 2) * half.x + x / 2)] +=
            exact[static_cast<std::size_t>(i)] / 8;
      }
      exact = means;
      size = half;
      double bias = 0;
      for (std::size_t i = 0; i < level.size(); ++i) {
        ASSERT_LE(std::abs(level[i] - exact[i]), 1.5) << "level " << k + 1;
        bias += (level[i] - exact[i]) / static_cast<double>(level.size());
      }
      if (level.size() >= 512 && amplitude >= 255) {
        // Pure noise meets every rounding half the time: 0.25 after odd levels, plus chance.
        EXPECT_LT(std::abs(bias), 0.26) << "level " << k + 1 << " amplitude " << amplitude;
      }
    }
  }
}

}  // namespace
}  // namespace octavo
