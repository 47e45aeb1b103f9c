#include "octavo/render/annotation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/render/numbers.h"

namespace octavo {

namespace {

constexpr std::int64_t kLegendLines = 14;  // as wide as so many lines are high
constexpr Color kMiddleGrey = {128, 128, 128};
constexpr std::int64_t kSmallestArea = 96;  // pixels of the shorter side

bool is_top(Corner corner) { return corner == Corner::top_left || corner == Corner::top_right; }

bool is_left(Corner corner) { return corner == Corner::top_left || corner == Corner::bottom_left; }

/// The other corner of the same edge, top or bottom.
Corner beside(Corner corner) {
  if (is_top(corner)) return is_left(corner) ? Corner::top_right : Corner::top_left;
  return is_left(corner) ? Corner::bottom_right : Corner::bottom_left;
}

}  // namespace

double text_size_px(const PixelArea& area) {
  const auto side = static_cast<double>(std::min(area.width, area.height));
  return std::clamp(5 + side / 52, 11.0, 400.0);
}

double round_length_mm(double maximum_mm) {
  const double power = std::pow(10.0, std::floor(std::log10(maximum_mm)));
  for (const double step : {10.0, 5.0, 2.0}) {
    if (step * power <= maximum_mm) return step * power;
  }
  return power;
}

std::string length_text(double length_mm) {
  struct Unit {
    const char* name;
    double mm;
  };
  constexpr Unit kUnits[] = {{" m", 1000}, {" mm", 1}, {" \u00b5m", 1e-3}, {" nm", 1e-6}};
  const Unit* unit = std::find_if(std::begin(kUnits), std::end(kUnits) - 1,
                                  [&](const Unit& u) { return length_mm >= u.mm * (1 - 1e-9); });
  const double count = length_mm / unit->mm;
  return (count < 0.5 ? short_number(count) : std::to_string(std::llround(count))) + unit->name;
}

Annotator::Annotator(Picture& picture)
    : Annotator(picture, {0, 0, picture.width, picture.height}) {}

Annotator::Annotator(Picture& picture, const PixelArea& area)
    : Annotator(picture, area, text_size_px(area)) {}

Annotator::Annotator(Picture& picture, const PixelArea& area, double text_px)
    : picture_(picture),
      area_(area),
      small_(text_px),
      large_(1.25 * text_px),
      margin_(std::llround(text_px * 0.6)) {}

bool Annotator::has_room() const { return std::min(area_.width, area_.height) >= kSmallestArea; }

/// Rows that are left in a corner; the middle of the area belongs to the letters of the sides.
std::int64_t Annotator::free_height(Corner corner) const {
  const std::int64_t middle = area_.height / 2 - small_.line_height();
  return middle - margin_ - used_[static_cast<std::size_t>(corner)];
}

/// Columns that a text may have in a corner.
std::int64_t Annotator::free_width(Corner corner) const {
  const std::int64_t gap = small_.cap_height();
  const std::int64_t other = widest_[static_cast<std::size_t>(beside(corner))];
  const std::int64_t letter = letters_[is_top(corner) ? 0 : 1];
  const std::int64_t free = area_.width - 2 * margin_ - (other == 0 ? 0 : other + 2 * gap);
  if (letter == 0 || is_past_letter(corner)) return free;
  return std::min(free, (area_.width - letter) / 2 - margin_ - gap);
}

/// Whether what a corner takes next lies no longer beside the letter of its edge.
bool Annotator::is_past_letter(Corner corner) const {
  return used_[static_cast<std::size_t>(corner)] >= large_.cap_height();
}

/// Leaves the rows beside the letter free where a text has room beyond them alone.
void Annotator::pass_letter(Corner corner, std::string_view text) {
  if (is_past_letter(corner) || small_.width(text) <= free_width(corner)) return;
  std::int64_t& used = used_[static_cast<std::size_t>(corner)];
  const std::int64_t before = std::exchange(used, large_.cap_height() + small_.cap_height() / 2);
  if (small_.width(text) > free_width(corner)) used = before;
}

/// Takes rows of a corner for something so wide, and gives the first of them.
std::int64_t Annotator::take(Corner corner, std::int64_t width, std::int64_t height) {
  std::int64_t& widest = widest_[static_cast<std::size_t>(corner)];
  widest = std::max(widest, width);
  std::int64_t& used = used_[static_cast<std::size_t>(corner)];
  const std::int64_t from_edge = margin_ + used;
  used += height;
  return is_top(corner) ? area_.y + from_edge : area_.y + area_.height - from_edge - height;
}

/// The first column of something so wide.
std::int64_t Annotator::column(Corner corner, std::int64_t width) const {
  return is_left(corner) ? area_.x + margin_ : area_.x + area_.width - margin_ - width;
}

void Annotator::box(const PixelArea& area, const Color& color) {
  for (std::int64_t y = area.y; y < area.y + area.height; ++y) {
    for (std::int64_t x = area.x; x < area.x + area.width; ++x) picture_.set(x, y, color);
  }
}

void Annotator::scale_bar(double pixel_mm) {
  if (!has_room()) return;
  const double length_mm = round_length_mm(pixel_mm * static_cast<double>(area_.width) / 4);
  const std::int64_t length = std::max<std::int64_t>(1, std::llround(length_mm / pixel_mm));
  const std::int64_t thickness = std::max<std::int64_t>(2, small_.cap_height() / 4);
  const std::int64_t edge = small_.outline();
  const std::int64_t x = column(Corner::bottom_left, length);
  const std::int64_t y = take(Corner::bottom_left, length, thickness);
  box({x - edge, y - edge, length + 2 * edge, thickness + 2 * edge}, colors_.outline);
  box({x, y, length, thickness}, colors_.letter);
  const std::string text = length_text(length_mm);
  const std::int64_t text_y = take(Corner::bottom_left, small_.width(text), small_.line_height());
  small_.draw(picture_, x, text_y + small_.line_height() / 8, text, colors_);
}

void Annotator::sides(const EdgeLetters& letters) {
  if (!has_room()) return;
  const std::int64_t cap = large_.cap_height();
  const auto centered = [&](const std::string& text) {
    return area_.x + (area_.width - large_.width(text)) / 2;
  };
  const std::int64_t middle_y = area_.y + (area_.height - cap) / 2;
  const std::int64_t right_x = area_.x + area_.width - margin_ - large_.width(letters.right);
  large_.draw(picture_, area_.x + margin_, middle_y, letters.left, colors_);
  large_.draw(picture_, right_x, middle_y, letters.right, colors_);
  large_.draw(picture_, centered(letters.top), area_.y + margin_, letters.top, colors_);
  large_.draw(picture_, centered(letters.bottom), area_.y + area_.height - margin_ - cap,
              letters.bottom, colors_);
  letters_ = {large_.width(letters.top), large_.width(letters.bottom)};
}

void Annotator::lines(Corner corner, std::span<const std::string> texts) {
  if (!has_room()) return;
  std::vector<std::string> outward(texts.begin(), texts.end());
  if (!is_top(corner)) std::reverse(outward.begin(), outward.end());
  for (const std::string& text : outward) {
    pass_letter(corner, text);
    if (free_height(corner) < small_.line_height()) return;
    const std::int64_t width = small_.width(text);
    if (width > free_width(corner)) continue;  // half a number would be another one
    const std::int64_t y = take(corner, width, small_.line_height());
    // The capitals of the outermost line touch the margin.
    const std::int64_t shift = is_top(corner) ? 0 : small_.line_height() - small_.cap_height();
    small_.draw(picture_, column(corner, width), y + shift, text, colors_);
  }
}

void Annotator::skip_line(Corner corner) { take(corner, 0, small_.line_height()); }

void Annotator::legend(Corner corner, std::span<const LegendRow> rows) {
  if (!has_room() || rows.empty()) return;
  const std::int64_t pitch = small_.line_height();
  const std::int64_t side = small_.cap_height();
  const std::int64_t gap = side / 2;
  const std::int64_t room = std::max<std::int64_t>(0, free_height(corner) / pitch);
  const auto fitting = static_cast<std::size_t>(room);
  const std::size_t shown = rows.size() <= fitting ? rows.size() : fitting > 0 ? fitting - 1 : 0;

  // Squares in one column, and names that leave most of the picture to be seen.
  const std::int64_t most = std::min(area_.width / 2, kLegendLines * pitch);
  const std::int64_t widest = std::min(free_width(corner), most) - side - gap;
  std::vector<std::string> texts;
  std::int64_t width = 0;
  for (const LegendRow& row : rows.first(shown)) {
    texts.push_back(small_.fitted(row.text, widest));
    width = std::max(width, side + gap + small_.width(texts.back()));
  }

  const std::int64_t x = column(corner, width);
  const std::int64_t edge = std::max<std::int64_t>(1, small_.outline() / 2);
  for (std::size_t i = 0; i < shown; ++i) {
    const LegendRow& row = rows[i];
    const std::int64_t y = take(corner, width, pitch);
    box({x - edge, y - edge, side + 2 * edge, side + 2 * edge}, colors_.outline);
    // A square of the color of the ground is seen by its border.
    if (row.color == colors_.outline) box({x, y, side, side}, kMiddleGrey);
    const std::int64_t border = row.color == colors_.outline ? 1 : 0;
    box({x + border, y + border, side - 2 * border, side - 2 * border}, row.color);
    small_.draw(picture_, x + side + gap, y, texts[i], colors_);
  }
  if (shown == rows.size() || fitting == 0) return;
  const std::string rest[] = {"+ " + std::to_string(rows.size() - shown) + " more"};
  lines(corner, rest);
}

void Annotator::color_bar(Corner corner, std::span<const Color> colors,
                          const std::array<std::string, 2>& ends) {
  const std::int64_t pitch = small_.line_height();
  const std::int64_t height = 5 * pitch;
  if (!has_room() || colors.empty() || free_height(corner) < height) return;
  const std::int64_t width = small_.cap_height();
  const std::int64_t edge = std::max<std::int64_t>(1, small_.outline() / 2);
  const std::int64_t x = column(corner, width);
  const std::int64_t text_width = std::max(small_.width(ends[0]), small_.width(ends[1]));
  const std::int64_t y = take(corner, width * 3 / 2 + text_width, height);
  const std::int64_t bar = height - pitch / 2;
  box({x - edge, y - edge, width + 2 * edge, bar + 2 * edge}, colors_.outline);
  for (std::int64_t row = 0; row < bar; ++row) {
    const auto count = static_cast<std::int64_t>(colors.size());
    const auto at = static_cast<std::size_t>((bar - 1 - row) * count / bar);
    box({x, y + row, width, 1}, colors[at]);
  }
  const auto text_x = [&](const std::string& text) {
    return is_left(corner) ? x + width * 3 / 2 : x - width / 2 - small_.width(text);
  };
  small_.draw(picture_, text_x(ends[1]), y, ends[1], colors_);
  small_.draw(picture_, text_x(ends[0]), y + bar - small_.cap_height(), ends[0], colors_);
}

void Annotator::text_beside(double x, double y, std::string_view text) {
  if (!has_room()) return;
  const double half = static_cast<double>(small_.cap_height()) / 2;
  small_.draw(picture_, area_.x + std::lround(x + 2 * half), area_.y + std::lround(y - half), text,
              colors_);
}

void Annotator::axes(const std::array<ViewAxis, 3>& axes) {
  if (!has_room()) return;
  const auto arm = 3.2 * static_cast<double>(small_.cap_height());
  const auto reach = static_cast<std::int64_t>(arm) + 2 * small_.cap_height();
  const std::int64_t top = take(Corner::bottom_right, 2 * reach, 2 * reach - margin_);
  const std::int64_t middle_x = area_.x + area_.width - reach;
  const std::int64_t middle_y = top + reach;
  const PixelArea around{middle_x - reach, middle_y - reach, 2 * reach, 2 * reach};
  const PixelPoint middle{static_cast<double>(middle_x), static_cast<double>(middle_y)};
  const auto end_of = [&](const ViewAxis& axis, double length) {
    return PixelPoint{middle.x + axis.right * length, middle.y - axis.up * length};
  };

  // Lines in a dark outline.
  const double line = std::max(1.5, static_cast<double>(small_.cap_height()) / 6);
  StrokeMask outlines(around, line + 2 * static_cast<double>(small_.outline()));
  StrokeMask strokes(around, line);
  for (const ViewAxis& axis : axes) {
    const PixelPoint points[] = {middle, end_of(axis, arm)};
    outlines.add(points);
    strokes.add(points);
  }
  outlines.draw(picture_, colors_.outline);
  strokes.draw(picture_, colors_.letter);

  // Names beyond the ends; beside the middle where an axis points at the viewer.
  const auto cap = static_cast<double>(small_.cap_height());
  for (const ViewAxis& axis : axes) {
    const double length = std::hypot(axis.right, axis.up);
    const bool is_seen = length > 0.05;
    const double right = is_seen ? axis.right / length : -0.7;
    const double up = is_seen ? axis.up / length : -0.7;
    const PixelPoint tip = end_of(axis, arm);
    small_.draw(picture_, std::llround(tip.x + right * cap) - small_.width(axis.name) / 2,
                std::llround(tip.y - up * cap) - small_.cap_height() / 2, axis.name, colors_);
  }
}

}  // namespace octavo
