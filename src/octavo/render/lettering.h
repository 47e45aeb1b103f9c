// Letters on pictures: a font that is part of the library, anti-aliased, in an outline so that they
// read on any ground.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "octavo/render/picture.h"

namespace octavo {

/// The color of letters and that of their outline.
struct LetterColors {
  Color letter = {255, 255, 255};
  Color outline = kBlack;
};

/// White letters on a dark ground, black ones on a light one.
LetterColors letter_colors_on(const Color& ground);

/// The letters of one size. One object serves one thread.
class Lettering {
 public:
  /// size_px  of the font, in pixels; capital letters are 0.73 of it high
  /// Throws   Error{invalid_argument} below 4 or above 1000
  explicit Lettering(double size_px);
  ~Lettering();
  Lettering(const Lettering&) = delete;
  Lettering& operator=(const Lettering&) = delete;

  /// Rows that capital letters and digits cover.
  std::int64_t cap_height() const;
  /// Rows from a line of text to the next.
  std::int64_t line_height() const;
  /// Pixels that the outline reaches beyond the letters.
  std::int64_t outline() const;
  /// Columns of a text without its outline.
  std::int64_t width(std::string_view text) const;

  /// `text` itself where it is at most `max_width` wide; otherwise its beginning and an ellipsis,
  /// or nothing where not even one letter fits.
  std::string fitted(std::string_view text, std::int64_t max_width) const;

  /// Draws a line of UTF-8 text, the upper left corner of its capital letters at (x, y). A letter
  /// that the font does not have becomes a question mark. Pixels outside the picture are cropped.
  void draw(Picture& picture, std::int64_t x, std::int64_t y, std::string_view text,
            const LetterColors& colors = {}) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

}  // namespace octavo
