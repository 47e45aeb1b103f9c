#include "octavo/render/numbers.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(Numbers, AreShortButKeepAllDigitsBeforeThePoint) {
  EXPECT_EQ(short_number(0.95703), "0.957");
  EXPECT_EQ(short_number(-1024), "-1024");
  EXPECT_EQ(short_number(15883.5), "15884");
  EXPECT_EQ(short_number(-32768, 3), "-32768");
  EXPECT_EQ(short_number(2.5e8), "2.5e+08");
  EXPECT_EQ(short_number(-1e-30 * 0), "0");
  EXPECT_EQ(with_unit(40, "HU"), "40 HU");
  EXPECT_EQ(with_unit(40, ""), "40");
  EXPECT_EQ(with_unit("0.40", "mm"), "0.40 mm");
  EXPECT_EQ(joined({0.957031, 0.957031, 1.5}, " x ", 3), "0.957 x 0.957 x 1.5");
}

TEST(Numbers, PlacesAreAsExactAsTheirSteps) {
  EXPECT_EQ(place_number(-20.7624, 0.52), "-20.76");
  EXPECT_EQ(place_number(122.496, 0.957), "122.5");
  EXPECT_EQ(place_number(3.75, 1.25), "3.8");
  EXPECT_EQ(place_number(764.2, 7), "764.2");
  EXPECT_EQ(place_number(764.2, 30), "764");
  EXPECT_EQ(place_number(1.95312, 0.01953), "1.953");
}

}  // namespace
}  // namespace octavo
