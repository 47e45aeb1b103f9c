#include "octavo/render/annotation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {
namespace {

/// Pixels of an area that are not black.
std::int64_t drawn_in(const Picture& picture, const PixelArea& area) {
  std::int64_t count = 0;
  for (std::int64_t y = area.y; y < area.y + area.height; ++y) {
    for (std::int64_t x = area.x; x < area.x + area.width; ++x) {
      const auto at = static_cast<std::size_t>((y * picture.width + x) * picture.channels);
      count += picture.pixels[at] != 0 ? 1 : 0;
    }
  }
  return count;
}

/// The smallest area with all that is not black.
PixelArea extent(const Picture& picture) {
  std::int64_t left = picture.width, right = -1, top = picture.height, bottom = -1;
  for (std::int64_t y = 0; y < picture.height; ++y) {
    for (std::int64_t x = 0; x < picture.width; ++x) {
      if (drawn_in(picture, {x, y, 1, 1}) == 0) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  return {left, top, right - left + 1, bottom - top + 1};
}

TEST(Lettering, CapitalsStandWhereTheyAreAsked) {
  for (const double size : {11.0, 24.0, 80.0}) {
    const Lettering letters(size);
    Picture picture = make_picture(300, 120, 1);
    letters.draw(picture, 20, 10, "HI");
    const PixelArea found = extent(picture);
    EXPECT_EQ(found.y, 10);
    EXPECT_EQ(found.height, letters.cap_height());
    EXPECT_NEAR(static_cast<double>(letters.cap_height()), 0.73 * size, 1);
    EXPECT_GE(found.x, 20);
    EXPECT_LE(found.x + found.width, 20 + letters.width("HI"));
  }
}

TEST(Lettering, ADarkOutlineSurroundsTheLetters) {
  const Lettering letters(30);
  Picture picture = make_picture(80, 60, 1);
  std::fill(picture.pixels.begin(), picture.pixels.end(), std::uint8_t{255});
  letters.draw(picture, 20, 15, "I");
  // Across the middle of the letter: ground, outline, letter, outline, ground.
  std::vector<int> runs;
  for (std::int64_t x = 0; x < picture.width; ++x) {
    const int value = picture.pixels[static_cast<std::size_t>(26 * picture.width + x)];
    const int kind = value > 200 ? 255 : value < 60 ? 0 : -1;
    if (kind >= 0 && (runs.empty() || runs.back() != kind)) runs.push_back(kind);
  }
  EXPECT_EQ(runs, (std::vector<int>{255, 0, 255, 0, 255}));
}

TEST(Lettering, EveryUtf8TextIsDrawn) {
  const Lettering letters(20);
  const auto pixels = [&](const std::string& text) {
    Picture picture = make_picture(200, 40, 3);
    letters.draw(picture, 4, 10, text);
    return picture.pixels;
  };
  // What the font lacks and what is no UTF-8 are question marks.
  EXPECT_EQ(pixels("a\xf0\x9f\xa7\xa0z"), pixels("a?z"));
  EXPECT_EQ(pixels("a\xe6\xb0\xb4z"), pixels("a?z"));
  EXPECT_EQ(pixels("a\xffz"), pixels("a?z"));
  EXPECT_EQ(pixels("a\xc3"), pixels("a?"));
  for (const char* sign : {"\u00b5", "\u00b0", "\u00b2", "\u00b1", "\u2013", "\u00e9", "\u0142"}) {
    EXPECT_NE(pixels(sign), pixels("?")) << sign;
    EXPECT_NE(pixels(sign), pixels("")) << sign;
  }
}

TEST(Lettering, TextsAreFittedToAWidth) {
  const Lettering letters(16);
  const std::string text = "Gyrus temporalis sup\u00e9rieur";
  EXPECT_EQ(letters.fitted(text, 1000), text);
  for (std::int64_t width = 0; width < letters.width(text); width += 7) {
    const std::string fitted = letters.fitted(text, width);
    EXPECT_LE(letters.width(fitted), width);
    EXPECT_TRUE(fitted.empty() || fitted.ends_with("\u2026"));
  }
  EXPECT_EQ(letters.fitted(text, 3), "");
  EXPECT_THROW(Lettering(2), Error);
  EXPECT_THROW(Lettering(5000), Error);
}

TEST(Lettering, LettersAtTheEdgeAreCropped) {
  const Lettering letters(40);
  Picture picture = make_picture(20, 20, 3);
  letters.draw(picture, -10, -10, "HHH");
  letters.draw(picture, 15, 15, "HHH");
  EXPECT_GT(drawn_in(picture, {0, 0, 20, 20}), 10);
}

TEST(ScaleBar, LengthsAreRound) {
  EXPECT_DOUBLE_EQ(round_length_mm(64), 50);
  EXPECT_DOUBLE_EQ(round_length_mm(50), 50);
  EXPECT_DOUBLE_EQ(round_length_mm(49), 20);
  EXPECT_DOUBLE_EQ(round_length_mm(0.17), 0.1);
  EXPECT_EQ(length_text(50), "50 mm");
  EXPECT_EQ(length_text(0.2), "200 \u00b5m");
  EXPECT_EQ(length_text(2000), "2 m");
  EXPECT_EQ(length_text(5e-6), "5 nm");
  EXPECT_EQ(length_text(1e-6), "1 nm");
  EXPECT_EQ(length_text(2e-7), "0.2 nm");
  EXPECT_EQ(length_text(5e-10), "0.0005 nm");
}

TEST(ScaleBar, IsAsLongAsItSays) {
  Picture picture = make_picture(400, 300, 1);
  Annotator(picture).scale_bar(0.5);  // a quarter is 50 mm: 100 pixels
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

TEST(Annotator, LettersOfAnEdgeStayInsideThePicture) {
  Picture one = make_picture(200, 150, 3);
  Picture three = make_picture(200, 150, 3);
  Annotator(one).sides({"R", "L", "S", "I"});
  Annotator(three).sides({"RAS", "LPI", "SRA", "ILP"});
  for (const PixelArea& edge : std::vector<PixelArea>{
           {0, 60, 60, 30}, {140, 60, 60, 30}, {70, 0, 60, 25}, {70, 125, 60, 25}}) {
    EXPECT_GT(drawn_in(one, edge), 5);
    EXPECT_GT(drawn_in(three, edge), 2 * drawn_in(one, edge));
  }
  EXPECT_EQ(drawn_in(three, {197, 0, 3, 150}), 0);
}

TEST(Annotator, LinesOfACornerStandBelowEachOther) {
  const std::string texts[] = {"HHH", "HHH", "HHH"};
  for (const Corner corner :
       {Corner::top_left, Corner::top_right, Corner::bottom_left, Corner::bottom_right}) {
    Picture one = make_picture(300, 300, 1);
    Picture three = make_picture(300, 300, 1);
    Annotator(one).lines(corner, {texts, 1});
    Annotator(three).lines(corner, texts);
    const std::int64_t drawn = drawn_in(one, {0, 0, 300, 300});
    EXPECT_EQ(drawn_in(three, {0, 0, 300, 300}), 3 * drawn);
    const bool is_left = corner == Corner::top_left || corner == Corner::bottom_left;
    const bool is_top = corner == Corner::top_left || corner == Corner::top_right;
    EXPECT_EQ(drawn_in(three, {is_left ? 0 : 150, is_top ? 0 : 150, 150, 150}), 3 * drawn);
  }
}

TEST(Annotator, LinesEndBeforeWhatStandsOnTheSameEdge) {
  Picture alone = make_picture(300, 300, 1);
  Annotator(alone).scale_bar(0.5);
  const PixelArea bar = extent(alone);
  const PixelArea beside{0, 0, bar.x + bar.width + 4, 300};
  std::size_t longest = 0;
  for (std::size_t length = 1; length < 60; ++length) {
    const std::string texts[] = {std::string(length, 'H')};
    Picture lined = make_picture(300, 300, 1);
    Annotator writing(lined);
    writing.scale_bar(0.5);
    writing.lines(Corner::bottom_right, texts);
    EXPECT_EQ(drawn_in(lined, beside), drawn_in(alone, beside)) << length;
    if (lined.pixels != alone.pixels) longest = length;
  }
  EXPECT_GT(longest, 10u);
  EXPECT_LT(longest, 30u);
}

TEST(Annotator, LinesThatHaveNoRoomBesideALetterStandBelowIt) {
  const auto rows_of = [](const std::string& text) {
    Picture picture = make_picture(200, 200, 1);
    Annotator writing(picture);
    writing.sides({"", "", "A", ""});
    const PixelArea letter = extent(picture);
    const std::string texts[] = {text};
    writing.lines(Corner::top_left, texts);
    const PixelArea below{0, letter.y + letter.height + 2, 200, 60};
    return std::pair(drawn_in(picture, {0, 0, letter.x - 1, letter.y + letter.height}),
                     drawn_in(picture, below));
  };
  EXPECT_GT(rows_of("HH").first, 20);
  EXPECT_EQ(rows_of("HH").second, 0);
  const auto [beside, below] = rows_of("HHHHHHHHHHHHHH");
  EXPECT_EQ(beside, 0);
  EXPECT_GT(below, 100);
}

TEST(Annotator, LettersAreDarkOnALightGround) {
  Picture picture = make_picture(200, 200, 3);
  std::fill(picture.pixels.begin(), picture.pixels.end(), std::uint8_t{255});
  Annotator writing(picture);
  writing.set_ground({255, 255, 255});
  writing.scale_bar(1);
  writing.sides({"R", "L", "S", "I"});
  EXPECT_GT(std::count(picture.pixels.begin(), picture.pixels.end(), 0), 100);
  EXPECT_EQ(letter_colors_on({90, 200, 90}).letter, kBlack);
  EXPECT_EQ(letter_colors_on({50, 90, 220}).outline, kBlack);
}

TEST(Annotator, LegendsShowWhatHasRoomAndCountTheRest) {
  const std::vector<LegendRow> rows(40, {{250, 10, 20}, "226:"});
  Picture picture = make_picture(160, 160, 3);
  Annotator(picture).legend(Corner::top_left, rows);
  EXPECT_GT(drawn_in(picture, {0, 0, 80, 40}), 100);
  EXPECT_EQ(drawn_in(picture, {0, 80, 160, 80}), 0);
  Picture few = make_picture(160, 160, 3);
  Annotator(few).legend(Corner::top_left, {rows.data(), 3});
  EXPECT_NE(few.pixels, picture.pixels);
  Picture small = make_picture(40, 40, 3);
  Annotator(small).legend(Corner::top_left, rows);
  EXPECT_EQ(drawn_in(small, {0, 0, 40, 40}), 0);
}

TEST(Annotator, AxesPointWhereTheyLead) {
  Picture picture = make_picture(300, 300, 1);
  Annotator(picture).axes({ViewAxis{"", 1, 0, 0}, ViewAxis{"", 0, 1, 0}, ViewAxis{"", 0, 0, 1}});
  const PixelArea found = extent(picture);
  EXPECT_NEAR(static_cast<double>(found.width), static_cast<double>(found.height), 1);
  // From a corner at the lower left to the right and up.
  EXPECT_GT(drawn_in(picture, {found.x, found.y + found.height - 2, found.width, 1}),
            found.width - 4);
  EXPECT_GT(drawn_in(picture, {found.x + 1, found.y, 1, found.height}), found.height - 4);
  EXPECT_EQ(drawn_in(picture, {found.x + 6, found.y, found.width - 6, found.height - 6}), 0);
}

TEST(StrokeMask, CoversWhatIsNearALine) {
  const PixelPoint points[] = {{3, 4}, {17, 9}, {12, 18}};
  StrokeMask mask({0, 0, 24, 24}, 3);
  mask.add(points);
  for (std::int64_t y = 0; y < 24; ++y) {
    for (std::int64_t x = 0; x < 24; ++x) {
      // The distance to many points of the line.
      double nearest = 1e9;
      for (int i = 0; i < 2; ++i) {
        for (int k = 0; k <= 1000; ++k) {
          const double t = k / 1000.0;
          const PixelPoint &a = points[i], &b = points[i + 1];
          nearest = std::min(nearest, std::hypot(a.x + t * (b.x - a.x) - static_cast<double>(x),
                                                 a.y + t * (b.y - a.y) - static_cast<double>(y)));
        }
      }
      EXPECT_NEAR(mask.coverage(x, y), 255 * std::clamp(2 - nearest, 0.0, 1.0), 3);
    }
  }
  EXPECT_EQ(mask.coverage(-1, 5), 0);
}

}  // namespace
}  // namespace octavo
