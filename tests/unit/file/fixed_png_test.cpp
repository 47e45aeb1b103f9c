#include "octavo/file/fixed_png.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/read_png.h"

namespace octavo {
namespace {

std::uint8_t noise(std::uint32_t& state) {
  state = state * 1664525 + 1013904223;
  return static_cast<std::uint8_t>(state >> 24);
}

/// Values in runs of up to `longest` alike.
Bytes runs(std::size_t count, std::size_t longest) {
  std::uint32_t state = 7;
  Bytes values;
  while (values.size() < count) {
    const std::size_t run = 1 + noise(state) * longest / 256;
    values.insert(values.end(), std::min(run, count - values.size()), noise(state));
  }
  return values;
}

void expect_back(const PngPixels& pixels) {
  const Picture picture = testing::read_png(encode_fixed_png(pixels));
  ASSERT_EQ(static_cast<std::size_t>(picture.width), pixels.width);
  ASSERT_EQ(static_cast<std::size_t>(picture.height), pixels.height);
  ASSERT_EQ(static_cast<std::size_t>(picture.channels), pixels.channels);
  EXPECT_TRUE(std::ranges::equal(picture.pixels, pixels.values));
}

TEST(FixedPng, GivesItsPixelsBackInAnotherProgram) {
  for (const std::size_t channels : {1u, 3u}) {
    for (const std::size_t width : {1u, 2u, 7u, 85u, 256u}) {
      for (const std::size_t height : {1u, 3u, 256u}) {
        for (const std::size_t longest : {1u, 4u, 300u, 5000u}) {
          SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
          expect_back({width, height, channels, runs(width * height * channels, longest)});
        }
      }
    }
  }
}

TEST(FixedPng, TakesMatchesOfEveryLength) {
  for (std::size_t run = 1; run <= 600; ++run) {
    Bytes values(run, 9);
    values.front() = 8;
    expect_back({run, 1, 1, values});
  }
}

TEST(FixedPng, StaysBelowTheLargestThumbnail) {
  std::uint32_t state = 1;
  Bytes values(256 * 256 * 3);
  // Values from 144 on take the longest codes.
  std::ranges::generate(
      values, [&] { return static_cast<std::uint8_t>(144 + noise(state) % 112); });
  EXPECT_LT(encode_fixed_png({256, 256, 3, values}).size(), std::size_t{256} << 10);
}

// 0 5 | match of 3 at distance 1 | match of 4 at the distance of a row | 200 | end
TEST(FixedPng, HasTheBytesOfItsRule) {
  const Bytes expected = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
      0x52, 0x00, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x02, 0x08, 0x00, 0x00, 0x00, 0x00, 0x5a,
      0xc3, 0x22, 0xbf, 0x00, 0x00, 0x00, 0x0e, 0x49, 0x44, 0x41, 0x54, 0x78, 0x01, 0x63, 0x60,
      0x05, 0x02, 0x10, 0x71, 0x02, 0x00, 0x01, 0x95, 0x00, 0xec, 0xdd, 0xfb, 0x44, 0xa7, 0x00,
      0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  EXPECT_EQ(encode_fixed_png({4, 2, 1, {5, 5, 5, 5, 5, 5, 5, 200}}), expected);
}

}  // namespace
}  // namespace octavo
