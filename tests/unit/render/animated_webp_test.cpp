#include "octavo/render/animated_webp.h"

#include <gtest/gtest.h>
#include <webp/demux.h>

#include <cstdlib>

#include "octavo/core/error.h"

namespace octavo {
namespace {

Picture plain_picture(const Color& color) {
  Picture picture = make_picture(31, 20, 3);
  for (std::int64_t y = 0; y < 20; ++y) {
    for (std::int64_t x = 0; x < 31; ++x) picture.set(x, y, color);
  }
  return picture;
}

TEST(AnimatedWebp, HoldsItsPicturesInOrderAndTime) {
  const Color colors[] = {{200, 40, 30}, {20, 160, 60}, {30, 60, 210}};
  AnimatedWebp animation(8);
  for (const Color& color : colors) animation.add(plain_picture(color));
  const Bytes bytes = animation.finish();
  const WebPData data{bytes.data(), bytes.size()};
  WebPAnimDecoderOptions options;
  ASSERT_NE(WebPAnimDecoderOptionsInit(&options), 0);
  options.color_mode = MODE_RGBA;
  WebPAnimDecoder* const decoder = WebPAnimDecoderNew(&data, &options);
  ASSERT_NE(decoder, nullptr);
  WebPAnimInfo info;
  ASSERT_NE(WebPAnimDecoderGetInfo(decoder, &info), 0);
  EXPECT_EQ(info.frame_count, 3u);
  EXPECT_EQ(info.canvas_width, 31u);
  EXPECT_EQ(info.loop_count, 0u);
  int end = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    std::uint8_t* pixels = nullptr;
    int time = 0;
    ASSERT_NE(WebPAnimDecoderGetNext(decoder, &pixels, &time), 0);
    EXPECT_EQ(time, static_cast<int>(125 * (i + 1)));
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_LE(std::abs(static_cast<int>(pixels[4 * 310 + c]) - colors[i][c]), 8) << i;
    }
    end = time;
  }
  EXPECT_EQ(end, 375);
  WebPAnimDecoderDelete(decoder);
}

TEST(AnimatedWebp, OtherSizesAreRejected) {
  AnimatedWebp animation(8);
  animation.add(plain_picture({1, 2, 3}));
  EXPECT_THROW(animation.add(make_picture(8, 8, 3)), Error);
  AnimatedWebp wide(8);
  EXPECT_THROW(wide.add(make_picture(AnimatedWebp::kLongestSide + 1, 1, 3)), Error);
}

}  // namespace
}  // namespace octavo
