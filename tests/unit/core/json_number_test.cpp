#include "octavo/core/json_number.h"

#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>

namespace octavo {
namespace {

struct Row {
  double value;
  const char* text;
};

TEST(JsonNumber, IsTheTextThatStandsInFiles) {
  const Row rows[] = {
      {0, "0.0"}, {-0.0, "-0.0"}, {1, "1.0"}, {-1000, "-1000.0"}, {0.5, "0.5"}, {0.1, "0.1"},
      {1e-4, "0.0001"}, {1e-5, "1e-05"}, {123456789012345, "123456789012345.0"},
      {999999999999999, "999999999999999.0"}, {1e15, "1e+15"}, {1.5e100, "1.5e+100"},
      {12345.678, "12345.678"}, {0.00012, "0.00012"}, {-2.5e-10, "-2.5e-10"}, {5e-324, "5e-324"},
      {1.7976931348623157e308, "1.7976931348623157e+308"}, {2.2250738585072014e-308,
      "2.2250738585072014e-308"}, {18.5, "18.5"}, {1.0 / 3, "0.3333333333333333"},
      // Of two texts as short, the one that stands in files; and one that is longer than need be.
      {171.88357543945312, "171.88357543945313"}, {4.91e-6, "4.9099999999999996e-06"}};
  for (const Row& row : rows) EXPECT_EQ(json_number(row.value), row.text);
}

TEST(JsonNumber, WritesNullForWhatIsNoNumber) {
  EXPECT_EQ(json_number(std::numeric_limits<double>::infinity()), "null");
  EXPECT_EQ(json_number(-std::numeric_limits<double>::infinity()), "null");
  EXPECT_EQ(json_number(std::numeric_limits<double>::quiet_NaN()), "null");
}

TEST(JsonNumber, ReadsBackAsTheSameNumber) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200000; ++i) {
    const auto value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    const std::string text = json_number(value);
    double back = 0;
    std::from_chars(text.data(), text.data() + text.size(), back);
    ASSERT_EQ(std::bit_cast<std::uint64_t>(back), std::bit_cast<std::uint64_t>(value)) << text;
    ASSERT_LE(text.size(), 24U) << text;
  }
}

}  // namespace
}  // namespace octavo
