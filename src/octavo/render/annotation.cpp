#include "octavo/render/annotation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace octavo {

namespace {

constexpr std::int64_t kGlyphWidth = 5;
constexpr std::int64_t kGlyphHeight = 7;
constexpr std::int64_t kSmallestPicture = 64;
constexpr Color kWhite = {255, 255, 255};
constexpr Color kBlack = {0, 0, 0};

struct Glyph {
  char letter;
  std::array<const char*, kGlyphHeight> rows;
};

constexpr Glyph kGlyphs[] = {
    {'0', {" ### ", "#   #", "#  ##", "# # #", "##  #", "#   #", " ### "}},
    {'1', {"  #  ", " ##  ", "  #  ", "  #  ", "  #  ", "  #  ", " ### "}},
    {'2', {" ### ", "#   #", "    #", "   # ", "  #  ", " #   ", "#####"}},
    {'3', {" ### ", "#   #", "    #", "  ## ", "    #", "#   #", " ### "}},
    {'4', {"   # ", "  ## ", " # # ", "#  # ", "#####", "   # ", "   # "}},
    {'5', {"#####", "#    ", "#### ", "    #", "    #", "#   #", " ### "}},
    {'6', {"  ## ", " #   ", "#    ", "#### ", "#   #", "#   #", " ### "}},
    {'7', {"#####", "    #", "   # ", "  #  ", "  #  ", "  #  ", "  #  "}},
    {'8', {" ### ", "#   #", "#   #", " ### ", "#   #", "#   #", " ### "}},
    {'9', {" ### ", "#   #", "#   #", " ####", "    #", "   # ", " ##  "}},
    {'+', {"     ", "  #  ", "  #  ", "#####", "  #  ", "  #  ", "     "}},
    {'-', {"     ", "     ", "     ", "#####", "     ", "     ", "     "}},
    {'.', {"     ", "     ", "     ", "     ", "     ", " ##  ", " ##  "}},
    {':', {"     ", " ##  ", " ##  ", "     ", " ##  ", " ##  ", "     "}},
    {'A', {" ### ", "#   #", "#   #", "#####", "#   #", "#   #", "#   #"}},
    {'H', {"#   #", "#   #", "#   #", "#####", "#   #", "#   #", "#   #"}},
    {'I', {" ### ", "  #  ", "  #  ", "  #  ", "  #  ", "  #  ", " ### "}},
    {'L', {"#    ", "#    ", "#    ", "#    ", "#    ", "#    ", "#####"}},
    {'P', {"#### ", "#   #", "#   #", "#### ", "#    ", "#    ", "#    "}},
    {'R', {"#### ", "#   #", "#   #", "#### ", "# #  ", "#  # ", "#   #"}},
    {'S', {" ####", "#    ", "#    ", " ### ", "    #", "    #", "#### "}},
    {'U', {"#   #", "#   #", "#   #", "#   #", "#   #", "#   #", " ### "}},
    {'a', {"     ", "     ", " ### ", "    #", " ####", "#   #", " ####"}},
    {'b', {"#    ", "#    ", "#### ", "#   #", "#   #", "#   #", "#### "}},
    {'c', {"     ", "     ", " ### ", "#    ", "#    ", "#   #", " ### "}},
    {'d', {"    #", "    #", " ####", "#   #", "#   #", "#   #", " ####"}},
    {'e', {"     ", "     ", " ### ", "#   #", "#####", "#    ", " ### "}},
    {'f', {"  ## ", " #  #", " #   ", "###  ", " #   ", " #   ", " #   "}},
    {'g', {"     ", " ####", "#   #", "#   #", " ####", "    #", " ### "}},
    {'h', {"#    ", "#    ", "# ## ", "##  #", "#   #", "#   #", "#   #"}},
    {'i', {"  #  ", "     ", " ##  ", "  #  ", "  #  ", "  #  ", " ### "}},
    {'j', {"   # ", "     ", "  ## ", "   # ", "   # ", "#  # ", " ##  "}},
    {'k', {"#    ", "#    ", "#  # ", "# #  ", "##   ", "# #  ", "#  # "}},
    {'l', {" ##  ", "  #  ", "  #  ", "  #  ", "  #  ", "  #  ", " ### "}},
    {'m', {"     ", "     ", "## # ", "# # #", "# # #", "# # #", "# # #"}},
    {'n', {"     ", "     ", "#### ", "#   #", "#   #", "#   #", "#   #"}},
    {'o', {"     ", "     ", " ### ", "#   #", "#   #", "#   #", " ### "}},
    {'p', {"     ", "     ", "#### ", "#   #", "#### ", "#    ", "#    "}},
    {'q', {"     ", "     ", " ## #", "#  ##", " ####", "    #", "    #"}},
    {'r', {"     ", "     ", "# ## ", "##  #", "#    ", "#    ", "#    "}},
    {'s', {"     ", "     ", " ### ", "#    ", " ### ", "    #", "#### "}},
    {'t', {" #   ", " #   ", "###  ", " #   ", " #   ", " #  #", "  ## "}},
    {'u', {"     ", "     ", "#   #", "#   #", "#   #", "#  ##", "## # "}},
    {'v', {"     ", "     ", "#   #", "#   #", "#   #", " # # ", "  #  "}},
    {'w', {"     ", "     ", "#   #", "#   #", "# # #", "# # #", " # # "}},
    {'x', {"     ", "     ", "#   #", " # # ", "  #  ", " # # ", "#   #"}},
    {'y', {"     ", "     ", "#   #", "#   #", " ####", "    #", " ### "}},
    {'z', {"     ", "     ", "#####", "   # ", "  #  ", " #   ", "#####"}},
};

const Glyph* glyph_of(char letter) {
  const auto found = std::find_if(std::begin(kGlyphs), std::end(kGlyphs),
                                  [&](const Glyph& glyph) { return glyph.letter == letter; });
  return found == std::end(kGlyphs) ? nullptr : found;
}

void fill(Picture& picture, std::int64_t x, std::int64_t y, std::int64_t width, std::int64_t height,
          const Color& color) {
  for (std::int64_t row = y; row < y + height; ++row) {
    for (std::int64_t column = x; column < x + width; ++column) picture.set(column, row, color);
  }
}

/// Draws the dots of a text, each grown by `margin` pixels on all sides.
void draw_dots(Picture& picture, std::int64_t x, std::int64_t y, std::string_view text,
               std::int64_t dot, std::int64_t margin, const Color& color) {
  for (const char letter : text) {
    if (const Glyph* const glyph = glyph_of(letter)) {
      for (std::int64_t row = 0; row < kGlyphHeight; ++row) {
        for (std::int64_t column = 0; column < kGlyphWidth; ++column) {
          if (glyph->rows[static_cast<std::size_t>(row)][column] != '#') continue;
          fill(picture, x + column * dot - margin, y + row * dot - margin, dot + 2 * margin,
               dot + 2 * margin, color);
        }
      }
    }
    x += (kGlyphWidth + 1) * dot;
  }
}

/// Pixels of a dot: letters keep about the same share of a picture of any size.
std::int64_t dot_of(const Picture& picture) {
  return std::max<std::int64_t>(1, std::min(picture.width, picture.height) / 256);
}

bool has_room(const Picture& picture) {
  return std::min(picture.width, picture.height) >= kSmallestPicture;
}

}  // namespace

void draw_text(Picture& picture, std::int64_t x, std::int64_t y, std::string_view text,
               std::int64_t dot) {
  draw_dots(picture, x, y, text, dot, 1, kBlack);
  draw_dots(picture, x, y, text, dot, 0, kWhite);
}

double round_length_mm(double most_mm) {
  const double power = std::pow(10.0, std::floor(std::log10(most_mm)));
  for (const double step : {10.0, 5.0, 2.0}) {
    if (step * power <= most_mm) return step * power;
  }
  return power;
}

std::string length_text(double length_mm) {
  struct Unit {
    const char* name;
    double mm;
  };
  constexpr Unit kUnits[] = {{" m", 1000}, {" mm", 1}, {" um", 1e-3}, {" nm", 1e-6}};
  const Unit* unit = std::find_if(std::begin(kUnits), std::end(kUnits) - 1,
                                  [&](const Unit& u) { return length_mm >= u.mm * (1 - 1e-9); });
  return std::to_string(std::llround(length_mm / unit->mm)) + unit->name;
}

void draw_scale_bar(Picture& picture, double pixel_mm) {
  if (!has_room(picture)) return;
  const std::int64_t dot = dot_of(picture);
  const double length_mm = round_length_mm(pixel_mm * static_cast<double>(picture.width) / 4);
  const std::int64_t length = std::max<std::int64_t>(1, std::llround(length_mm / pixel_mm));
  const std::int64_t x = 6 * dot;
  const std::int64_t y = picture.height - 8 * dot;
  fill(picture, x - 1, y - 1, length + 2, 2 * dot + 2, kBlack);
  fill(picture, x, y, length, 2 * dot, kWhite);
  draw_text(picture, x, y - 10 * dot, length_text(length_mm), dot);
}

void draw_sides(Picture& picture, const SliceOrientation& orientation) {
  draw_sides(picture, {std::string(1, orientation.left), std::string(1, orientation.right),
                       std::string(1, orientation.top), std::string(1, orientation.bottom)});
}

void draw_sides(Picture& picture, const EdgeLetters& letters) {
  if (!has_room(picture)) return;
  const std::int64_t dot = dot_of(picture);
  const auto width_of = [&](const std::string& text) {
    return (static_cast<std::int64_t>(text.size()) * (kGlyphWidth + 1) - 1) * dot;
  };
  const auto centered = [&](const std::string& text) {
    return (picture.width - width_of(text)) / 2;
  };
  const std::int64_t far_x = picture.width - width_of(letters.right) - 4 * dot;
  const std::int64_t far_y = picture.height - (kGlyphHeight + 4) * dot;
  const std::int64_t middle_y = (picture.height - kGlyphHeight * dot) / 2;
  draw_text(picture, 4 * dot, middle_y, letters.left, dot);
  draw_text(picture, far_x, middle_y, letters.right, dot);
  draw_text(picture, centered(letters.top), 4 * dot, letters.top, dot);
  draw_text(picture, centered(letters.bottom), far_y, letters.bottom, dot);
}

void draw_legend(Picture& picture, std::span<const LegendRow> rows) {
  if (!has_room(picture)) return;
  const std::int64_t dot = dot_of(picture);
  const std::int64_t pitch = (kGlyphHeight + 4) * dot;
  const std::int64_t lowest = picture.height / 2 - 2 * pitch;  // above the letters at the left edge
  std::int64_t y = 4 * dot;
  for (const LegendRow& row : rows) {
    if (y > lowest) return;
    const std::int64_t side = kGlyphHeight * dot;
    fill(picture, 4 * dot - 1, y - 1, side + 2, side + 2, kBlack);
    fill(picture, 4 * dot, y, side, side, row.color);
    draw_text(picture, 4 * dot + side + 3 * dot, y, row.text, dot);
    y += pitch;
  }
}

}  // namespace octavo
