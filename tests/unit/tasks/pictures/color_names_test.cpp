#include "octavo/tasks/pictures/color_names.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(ColorNames, AreNamesOrSixDigits) {
  EXPECT_EQ(find_color("white"), (Color{255, 255, 255}));
  EXPECT_EQ(find_color("#0a10Ff"), (Color{10, 16, 255}));
  for (const char* text : {"", "whit", "#12", "#12345g", "123456", "#1234567", "# 12345"}) {
    EXPECT_FALSE(find_color(text)) << text;
  }
  EXPECT_NE(color_names().find("white, "), std::string::npos);
}

}  // namespace
}  // namespace octavo
