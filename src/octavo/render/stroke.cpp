#include "octavo/render/stroke.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

double distance_to(const PixelPoint& p, const PixelPoint& from, const PixelPoint& to) {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const double square = dx * dx + dy * dy;
  const double along = square > 0 ? ((p.x - from.x) * dx + (p.y - from.y) * dy) / square : 0;
  const double t = std::clamp(along, 0.0, 1.0);
  return std::hypot(p.x - from.x - t * dx, p.y - from.y - t * dy);
}

}  // namespace

StrokeMask::StrokeMask(const PixelArea& area, double width_px)
    : area_(area),
      radius_(width_px / 2),
      coverage_(static_cast<std::size_t>(area.width * area.height)) {}

void StrokeMask::add(std::span<const PixelPoint> points) {
  if (points.size() == 1) add_segment(points[0], points[0]);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) add_segment(points[i], points[i + 1]);
}

void StrokeMask::add_segment(const PixelPoint& from, const PixelPoint& to) {
  const double reach = radius_ + 0.5;
  const auto first = [&](double a, double b, std::int64_t lowest) {
    return std::max(lowest, static_cast<std::int64_t>(std::ceil(std::min(a, b) - reach)));
  };
  const auto last = [&](double a, double b, std::int64_t highest) {
    return std::min(highest, static_cast<std::int64_t>(std::floor(std::max(a, b) + reach)));
  };
  const std::int64_t right = last(from.x, to.x, area_.x + area_.width - 1);
  const std::int64_t bottom = last(from.y, to.y, area_.y + area_.height - 1);
  for (std::int64_t y = first(from.y, to.y, area_.y); y <= bottom; ++y) {
    for (std::int64_t x = first(from.x, to.x, area_.x); x <= right; ++x) {
      const PixelPoint pixel{static_cast<double>(x), static_cast<double>(y)};
      const double share = std::clamp(reach - distance_to(pixel, from, to), 0.0, 1.0);
      std::uint8_t& held =
          coverage_[static_cast<std::size_t>((y - area_.y) * area_.width + x - area_.x)];
      held = std::max(held, static_cast<std::uint8_t>(std::lround(255 * share)));
    }
  }
}

std::uint8_t StrokeMask::coverage(std::int64_t x, std::int64_t y) const {
  const std::int64_t column = x - area_.x;
  const std::int64_t row = y - area_.y;
  if (column < 0 || row < 0 || column >= area_.width || row >= area_.height) return 0;
  return coverage_[static_cast<std::size_t>(row * area_.width + column)];
}

void StrokeMask::draw(Picture& picture, const Color& color, double opacity) const {
  for (std::int64_t row = 0; row < area_.height; ++row) {
    for (std::int64_t column = 0; column < area_.width; ++column) {
      const std::uint8_t covered = coverage_[static_cast<std::size_t>(row * area_.width + column)];
      if (covered == 0) continue;
      picture.blend(area_.x + column, area_.y + row, color, opacity * covered / 255);
    }
  }
}

}  // namespace octavo
