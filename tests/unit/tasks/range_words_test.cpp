#include "octavo/tasks/range_words.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(RangeWords, TellAValueFromTheEndThatItLiesBeyond) {
  const OutsideWords above = outside_words(1000000.5, 0, 1000000);
  EXPECT_EQ(above.value, "1000000.5");
  EXPECT_EQ(above.highest, "1000000");
  EXPECT_EQ(above.lowest, "0");
  const OutsideWords below = outside_words(0.12345678, 0.12345679, 3e9);
  EXPECT_EQ(below.value, "0.12345678");
  EXPECT_EQ(below.lowest, "0.12345679");
  EXPECT_EQ(below.highest, "3e+09");
  EXPECT_EQ(outside_words(40000, -32768, 32767).value, "40000");
}

}  // namespace
}  // namespace octavo
