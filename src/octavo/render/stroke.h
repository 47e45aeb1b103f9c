// Anti-aliased lines: where lines meet or cross, no pixel is drawn twice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/render/picture.h"

namespace octavo {

/// A place in a picture; pixel (x, y) has its center at (x, y).
struct PixelPoint {
  double x = 0;
  double y = 0;

  bool operator==(const PixelPoint&) const = default;
};

/// A part of a picture.
struct PixelArea {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

/// How much of each pixel of an area is covered by lines of one width.
/// Memory  1 byte per pixel of the area
class StrokeMask {
 public:
  StrokeMask(const PixelArea& area, double width_px);

  /// Adds the line through `points`, its ends round. What lies outside the area is cropped.
  void add(std::span<const PixelPoint> points);

  /// Covered share of a pixel, 0 .. 255; 0 outside the area.
  std::uint8_t coverage(std::int64_t x, std::int64_t y) const;

  /// Mixes the covered pixels with a color.
  void draw(Picture& picture, const Color& color, double opacity = 1) const;

 private:
  void add_segment(const PixelPoint& from, const PixelPoint& to);

  PixelArea area_;
  double radius_;
  std::vector<std::uint8_t> coverage_;
};

}  // namespace octavo
