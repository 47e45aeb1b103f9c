#include "octavo/io/http/patience.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

const Patience::Time kStart{};

Patience::Time after(double seconds) {
  return kStart + std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

TEST(Patience, SilenceUsesItUp) {
  Patience patience(60, kStart);
  EXPECT_DOUBLE_EQ(patience.left(after(59)), 1);
  EXPECT_DOUBLE_EQ(patience.left(after(60)), 0);
  EXPECT_DOUBLE_EQ(patience.silence(after(60)), 60);
}

TEST(Patience, TenThousandBytesGiveASecondBackButNeverMoreThanAtTheStart) {
  Patience patience(60, kStart);
  patience.feed(100'000, after(20));
  EXPECT_DOUBLE_EQ(patience.left(after(20)), 50);
  patience.feed(1'000'000'000, after(30));
  EXPECT_DOUBLE_EQ(patience.left(after(30)), 60);
  EXPECT_DOUBLE_EQ(patience.silence(after(31)), 1);
}

TEST(Patience, WhatIsLeftOutCostsNothingAndGivesNothingBack) {
  Patience patience(60, kStart);
  patience.leave_out(30);
  EXPECT_DOUBLE_EQ(patience.left(after(50)), 40);
  EXPECT_DOUBLE_EQ(patience.silence(after(50)), 20);
  patience.leave_out(5);
  EXPECT_DOUBLE_EQ(patience.left(after(75)), 20);
  EXPECT_DOUBLE_EQ(patience.left_out(), 35);
}

TEST(Patience, WhoKeepsTheFloorIsNeverLateAndATrickleIs) {
  const auto end_at = [](std::uint64_t bytes_per_second) {
    Patience patience(60, kStart);
    for (int second = 1; second < 100'000; ++second) {
      if (patience.left(after(second)) <= 0) return second;
      patience.feed(bytes_per_second, after(second));
    }
    return 0;
  };
  EXPECT_EQ(end_at(10'000), 0);
  EXPECT_EQ(end_at(150), 61);
  EXPECT_EQ(end_at(5'000), 119);
}

}  // namespace
}  // namespace octavo
