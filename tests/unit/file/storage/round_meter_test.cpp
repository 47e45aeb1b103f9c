#include "octavo/file/storage/round_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace octavo {
namespace {

TEST(RoundMeter, NothingIsKnownUntilASmallAndALargeAnswerCame) {
  RoundMeter meter;
  EXPECT_EQ(meter.bytes_per_round(), 0u);
  meter.add(0.1, 1 << 20);
  EXPECT_EQ(meter.bytes_per_round(), 0u);
  meter.add(0.1, 100'000);  // neither of them
  EXPECT_EQ(meter.bytes_per_round(), 0u);
  meter.add(0.02, 0);
  EXPECT_EQ(meter.bytes_per_round(), (1u << 20) / 4);

  RoundMeter other;
  other.add(0.02, 1 << 16);
  EXPECT_EQ(other.bytes_per_round(), 0u);
}

TEST(RoundMeter, ASlowLineBringsLittleInARoundAFastOneAtMost16TimesWhatCame) {
  RoundMeter slow;
  slow.add(0.02, 0);
  slow.add(2.02, 1'000'000);
  EXPECT_NEAR(static_cast<double>(slow.bytes_per_round()), 10'000, 1);
  RoundMeter fast;
  fast.add(0.02, 0);
  fast.add(0.0201, 1'000'000);
  EXPECT_EQ(fast.bytes_per_round(), 16'000'000u);
  // Large answers may even come sooner than small ones.
  fast.add(0.01, 1'000'000);
  EXPECT_EQ(fast.bytes_per_round(), 16'000'000u);
}

TEST(RoundMeter, TheShortestRoundAndTheLatestLargeAnswerCount) {
  RoundMeter meter;
  meter.add(0.05, 10);
  meter.add(0.02, 10);
  meter.add(0.04, 10);
  meter.add(0.04, 4 << 20);
  EXPECT_EQ(meter.bytes_per_round(), 4u << 20);
  meter.add(0.06, 4 << 20);
  EXPECT_EQ(meter.bytes_per_round(), 2u << 20);
  meter.add(0.022, 300'000);  // too little to tell
  EXPECT_EQ(meter.bytes_per_round(), 2u << 20);
  meter.add(0.04, 1 << 20);
  EXPECT_EQ(meter.bytes_per_round(), 1u << 20);
}

TEST(RoundMeter, TimesThatAreNoneTeachNothing) {
  RoundMeter meter;
  for (const double seconds : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
    meter.add(seconds, 0);
    meter.add(seconds, 1 << 30);
  }
  EXPECT_EQ(meter.bytes_per_round(), 0u);
}

}  // namespace
}  // namespace octavo
