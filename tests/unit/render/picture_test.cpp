#include "octavo/render/picture.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/render/annotation.h"
#include "octavo/render/color_names.h"
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

TEST(Picture, ImpossiblePicturesAreRefused) {
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
  EXPECT_EQ(robust_window(std::vector<double>{3, 3, 3}).grey(3), 0);
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

TEST(ScaleBar, LengthsAreRound) {
  EXPECT_DOUBLE_EQ(round_length_mm(64), 50);
  EXPECT_DOUBLE_EQ(round_length_mm(50), 50);
  EXPECT_DOUBLE_EQ(round_length_mm(49), 20);
  EXPECT_DOUBLE_EQ(round_length_mm(0.17), 0.1);
  EXPECT_EQ(length_text(50), "50 mm");
  EXPECT_EQ(length_text(0.2), "200 um");
  EXPECT_EQ(length_text(2000), "2 m");
  EXPECT_EQ(length_text(5e-6), "5 nm");
}

TEST(ScaleBar, IsAsLongAsItSays) {
  Picture picture = make_picture(400, 300, 1);
  draw_scale_bar(picture, 0.5);  // a quarter is 50 mm: 100 pixels
  std::int64_t longest = 0;
  for (std::int64_t y = 0; y < picture.height; ++y) {
    std::int64_t run = 0;
    for (std::int64_t x = 0; x < picture.width; ++x) {
      run = picture.pixels[static_cast<std::size_t>(y * 400 + x)] == 255 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_EQ(longest, 100);
}

std::int64_t drawn_in(const Picture& picture, std::int64_t x0, std::int64_t x1, std::int64_t y0,
                      std::int64_t y1) {
  std::int64_t count = 0;
  for (std::int64_t y = y0; y < y1; ++y) {
    for (std::int64_t x = x0; x < x1; ++x) {
      count += picture.pixels[static_cast<std::size_t>((y * picture.width + x) * 3)] != 0 ? 1 : 0;
    }
  }
  return count;
}

TEST(Annotation, LettersOfAnEdgeStayInsideThePicture) {
  Picture one = make_picture(200, 150, 3);
  Picture three = make_picture(200, 150, 3);
  draw_sides(one, EdgeLetters{"R", "L", "S", "I"});
  draw_sides(three, EdgeLetters{"RAS", "LPI", "SRA", "ILP"});
  for (const auto& [x0, x1, y0, y1] : std::vector<std::array<std::int64_t, 4>>{
           {0, 30, 60, 90}, {170, 200, 60, 90}, {85, 115, 0, 20}, {85, 115, 130, 150}}) {
    EXPECT_GT(drawn_in(one, x0, x1, y0, y1), 5);
    EXPECT_GT(drawn_in(three, x0, x1, y0, y1), 2 * drawn_in(one, x0, x1, y0, y1));
  }
  EXPECT_EQ(drawn_in(three, 198, 200, 0, 150), 0);
}

TEST(Annotation, LegendsShowTheColorsThatHaveRoom) {
  const std::vector<LegendRow> rows(40, {{250, 10, 20}, "226:"});
  Picture picture = make_picture(160, 160, 3);
  draw_legend(picture, rows);
  EXPECT_GT(drawn_in(picture, 0, 60, 0, 40), 100);
  EXPECT_EQ(drawn_in(picture, 0, 160, 70, 160), 0);
  Picture small = make_picture(20, 20, 3);
  draw_legend(small, rows);
  EXPECT_EQ(drawn_in(small, 0, 20, 0, 20), 0);
}

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
