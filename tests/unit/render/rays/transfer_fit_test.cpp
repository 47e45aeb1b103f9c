#include "octavo/render/rays/transfer_fit.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace octavo {
namespace {

/// Two heaps of values: around 20 and, fewer of them, around `bright`.
std::vector<double> two_heaps(double bright, std::size_t few) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 5);
  std::vector<double> values;
  for (std::size_t i = 0; i < 20000; ++i) values.push_back(20 + noise(random));
  for (std::size_t i = 0; i < few; ++i) values.push_back(bright + noise(random));
  return values;
}

TEST(TransferFit, WhatLiesAroundIsNotSeenAndWhatIsBrightIs) {
  for (const double bright : {70.0, 200.0, 5000.0}) {
    for (const std::size_t few : {2000u, 20000u}) {
      const TransferFunction fitted = fitted_transfer(two_heaps(bright, few));
      EXPECT_EQ(fitted.opacity_at(20), 0) << bright;
      EXPECT_GT(fitted.opacity_at(bright), 0.05) << bright;
      EXPECT_GT(fitted.opacity_at(bright + 15), fitted.opacity_at(bright - 4));
      for (std::size_t i = 1; i < fitted.points.size(); ++i) {
        EXPECT_GE(fitted.points[i].value, fitted.points[i - 1].value);
      }
    }
  }
}

TEST(TransferFit, AFewVoxelsFarAboveDoNotMoveTheThreshold) {
  std::vector<double> values = two_heaps(90, 8000);
  const double threshold = fitted_transfer(values).points.front().value;
  for (int i = 0; i < 20; ++i) values.push_back(60000);
  EXPECT_NEAR(fitted_transfer(values).points.front().value, threshold, 2);
}

TEST(TransferFit, WhatFallsOffWithoutAHeapIsSeenFromItsDarkestOn) {
  // Nothing, and tissue from 2000 to 60000, most of it dim.
  std::mt19937 random(1);
  std::exponential_distribution<double> bright(1 / 6000.0);
  std::vector<double> values(30000, 0.0);
  for (int i = 0; i < 10000; ++i) values.push_back(2000 + bright(random));
  const TransferFunction fitted = fitted_transfer(values);
  EXPECT_EQ(fitted.opacity_at(0), 0);
  EXPECT_LT(fitted.points.front().value, 3000);
  EXPECT_GT(fitted.opacity_at(8000), 0.05);
}

TEST(TransferFit, OneValueOrNoneHasTheUsualFunction) {
  EXPECT_EQ(fitted_transfer({}), usual_transfer_function());
  EXPECT_EQ(fitted_transfer(std::vector<double>(10, 3.0)), usual_transfer_function());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(fitted_transfer({nan, nan}), usual_transfer_function());
  EXPECT_EQ(fitted_transfer({0, 1}).opacity_at(0), 0);
}

}  // namespace
}  // namespace octavo
