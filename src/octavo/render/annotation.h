// Writing on pictures: scale bar, sides of the patient, axes, lines of text, legends.
//
//     top left      lines and legends, downward       top right      the same
//     bottom left   scale bar                         bottom right   lines, axes; upward
//     edges         the patient's side at the middle of each
//
// What is written into a corner stands below or above what was written there before, not over it,
// and ends before what stands in the other corner of its edge and before the side's letter: scale
// bar and sides first, lines behind them. What has no room is not written. Letters grow with the
// picture.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/render/lettering.h"
#include "octavo/render/picture.h"
#include "octavo/render/stroke.h"
#include "octavo/render/view.h"

namespace octavo {

/// The length of a scale bar: the largest of 1, 2, 5 times a power of ten that is at most
/// `maximum_mm`.
double round_length_mm(double maximum_mm);

/// "50 mm", "200 µm", "2 m".
std::string length_text(double length_mm);

/// What one color of a picture stands for.
struct LegendRow {
  Color color{};
  std::string text;
};

/// The size of letters on a picture, or a part of one: about the same share of any, and legible on
/// a small one.
double text_size_px(const PixelArea& area);

enum class Corner { top_left, top_right, bottom_left, bottom_right };

/// Writes on one picture, or on a part of it.
class Annotator {
 public:
  /// `picture` must outlive this.
  explicit Annotator(Picture& picture);
  Annotator(Picture& picture, const PixelArea& area);
  /// With letters of another size.
  Annotator(Picture& picture, const PixelArea& area, double text_px);

  /// Has what follows written in colors that read best on a ground; without, on a dark one.
  void set_ground(const Color& ground) { colors_ = letter_colors_on(ground); }

  /// Writes a scale bar with its length.
  /// pixel_mm  side of a pixel
  void scale_bar(double pixel_mm);

  /// Writes the patient's sides at the four edges.
  void sides(const EdgeLetters& letters);

  /// Writes lines of text into a corner; those that are too long are left out.
  void lines(Corner corner, std::span<const std::string> texts);

  /// Leaves the rows of one line in a corner as they are.
  void skip_line(Corner corner);

  /// Writes a square of each color with its text into a corner; where not all have room, how many
  /// are not shown.
  void legend(Corner corner, std::span<const LegendRow> rows);

  /// Writes a bar of `colors`, from the lowest to the highest, with the texts of its ends.
  void color_bar(Corner corner, std::span<const Color> colors,
                 const std::array<std::string, 2>& ends);

  /// Writes a line of text to the right of a place, pixels; outside the picture it is cropped.
  void text_beside(double x, double y, std::string_view text);

  /// Draws three axes from one point at the lower right, with their names at their ends.
  void axes(const std::array<ViewAxis, 3>& axes);

 private:
  bool has_room() const;
  std::int64_t free_height(Corner corner) const;
  std::int64_t free_width(Corner corner) const;
  bool is_past_letter(Corner corner) const;
  void pass_letter(Corner corner, std::string_view text);
  std::int64_t take(Corner corner, std::int64_t width, std::int64_t height);
  std::int64_t column(Corner corner, std::int64_t width) const;
  void box(const PixelArea& area, const Color& color);

  Picture& picture_;
  PixelArea area_;
  Lettering small_;  // all lines
  Lettering large_;  // the sides
  std::int64_t margin_;
  LetterColors colors_;
  std::array<std::int64_t, 4> used_{};     // rows, by corner
  std::array<std::int64_t, 4> widest_{};   // columns, by corner
  std::array<std::int64_t, 2> letters_{};  // columns of the sides at the top and at the bottom
};

}  // namespace octavo
