#include "octavo/render/picture.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/render/label_color.h"
#include "octavo/render/window.h"
#include "support/read_png.h"

namespace octavo {
namespace {

TEST(Picture, PngHoldsThePixels) {
  for (const int channels : {1, 3}) {
    Picture picture = make_picture(31, 17, channels);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      picture.pixels[i] = static_cast<std::uint8_t>(i * 37);
    }
    const Bytes png = encode_png(picture);
    EXPECT_EQ(encode_png(picture), png);
    const Picture found = testing::read_png(png);
    EXPECT_EQ(found.width, 31);
    EXPECT_EQ(found.height, 17);
    EXPECT_EQ(found.pixels, picture.pixels);
  }
}

TEST(Picture, ImpossiblePicturesAreRejected) {
  EXPECT_THROW(encode_png({0, 5, 1, {}}), Error);
  EXPECT_THROW(encode_png({2, 2, 2, Bytes(8)}), Error);
  EXPECT_THROW(encode_png({2, 2, 1, Bytes(3)}), Error);
}

TEST(Window, RunsFromBlackToWhite) {
  const Window window{40, 80};
  EXPECT_EQ(window.grey(-1000), 0);
  EXPECT_EQ(window.grey(0), 0);
  EXPECT_EQ(window.grey(40), 128);
  EXPECT_EQ(window.grey(80), 255);
  EXPECT_EQ(window.grey(3000), 255);
  EXPECT_EQ(window.grey(std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(Window, PresetsAreFoundByName) {
  EXPECT_EQ(find_window_preset("lung"), (Window{-600, 1500}));
  EXPECT_FALSE(find_window_preset("knee"));
}

TEST(Window, AFewOutliersDoNotDecide) {
  std::vector<double> values;
  for (int i = 0; i <= 1000; ++i) values.push_back(i);
  values.push_back(1e9);
  values.push_back(std::numeric_limits<double>::infinity());
  const Window window = robust_window(values);
  EXPECT_NEAR(window.center, 500, 5);
  EXPECT_NEAR(window.width, 990, 10);
  EXPECT_EQ(robust_window(std::vector<double>{3, 3, 3}), (Window{1.5, 3}));
  EXPECT_EQ(robust_window(std::vector<double>{-3, -3}).grey(-3), 0);
  EXPECT_EQ(robust_window(std::vector<double>{0, 0}).grey(0), 0);
  EXPECT_EQ(robust_window(std::vector<double>{-3, 3 * (1 + 1e-13)}).center, 0);
  EXPECT_EQ(robust_window({}), Window{});
}

TEST(LabelColor, BackgroundIsBlackAndLabelsDiffer) {
  EXPECT_EQ(label_color(0), (Color{0, 0, 0}));
  std::set<Color> seen;
  for (std::int64_t label = 1; label <= 200; ++label) seen.insert(label_color(label));
  EXPECT_GE(seen.size(), 198u);
  for (std::int64_t label = 1; label < 2000; ++label) {
    const Color a = label_color(label);
    const Color b = label_color(label + 1);
    int difference = 0;
    for (std::size_t i = 0; i < 3; ++i) difference += std::abs(int{a[i]} - int{b[i]});
    EXPECT_GT(difference, 100) << label;
    EXPECT_GT(int{a[0]} + a[1] + a[2], 150) << label;
  }
}

}  // namespace
}  // namespace octavo
