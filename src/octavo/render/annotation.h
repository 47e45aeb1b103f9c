// Writing on pictures: a small font, the scale bar, the letters at the edges.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "octavo/render/picture.h"
#include "octavo/render/slice_orientation.h"
#include "octavo/render/view.h"

namespace octavo {

/// Draws text in white with a black outline, its upper left corner at (x, y). Letters are 5 x 7
/// dots of `dot` pixels, 6 dots apart. Known are digits, small letters, some capitals and ". :+-".
void draw_text(Picture& picture, std::int64_t x, std::int64_t y, std::string_view text,
               std::int64_t dot);

/// The length of a scale bar: the largest of 1, 2, 5 times a power of ten that is at most
/// `most_mm`.
double round_length_mm(double most_mm);

/// "50 mm", "200 um", "2 m".
std::string length_text(double length_mm);

/// Draws a scale bar with its length at the lower left. Does nothing when the picture has no room
/// for it.
/// pixel_mm  side of a pixel
void draw_scale_bar(Picture& picture, double pixel_mm);

/// Draws the patient's sides at the four edges. Does nothing when the picture has no room for them.
void draw_sides(Picture& picture, const SliceOrientation& orientation);
void draw_sides(Picture& picture, const EdgeLetters& letters);

/// What one color of a picture stands for.
struct LegendRow {
  Color color{};
  std::string text;
};

/// Draws a square of each color with its text at the upper left, as many as have room.
void draw_legend(Picture& picture, std::span<const LegendRow> rows);

}  // namespace octavo
