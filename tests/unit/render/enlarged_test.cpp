#include "octavo/render/enlarged.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(EnlargedPicture, KeepsARampWhereItIs) {
  Picture small = make_picture(40, 8, 1);
  for (std::int64_t y = 0; y < 8; ++y) {
    for (std::int64_t x = 0; x < 40; ++x) {
      small.pixels[static_cast<std::size_t>(y * 40 + x)] = static_cast<std::uint8_t>(6 * x + 3);
    }
  }
  const Picture large = enlarged(small, 80, 15, 2);
  ASSERT_EQ(large.width, 80);
  ASSERT_EQ(large.height, 15);
  for (std::int64_t x = 1; x < 79; ++x) {
    // The middle of pixel x lies at (x + 1/2) / 2 of the small one.
    EXPECT_NEAR(large.pixels[static_cast<std::size_t>(7 * 80 + x)],
                6 * ((static_cast<double>(x) + 0.5) / 2 - 0.5) + 3, 0.51)
        << x;
  }
}

TEST(EnlargedPicture, OfTheSameSizeIsTheSame) {
  Picture picture = make_picture(5, 4, 3);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    picture.pixels[i] = static_cast<std::uint8_t>(i * 37);
  }
  EXPECT_EQ(enlarged(picture, 5, 4, 1).pixels, picture.pixels);
}

}  // namespace
}  // namespace octavo
