// Which places of the pixels of a tile a polygon covers.
//
// Corners are rounded to 1/256 of a pixel; from then on everything is integer. Each pixel has 16
// places, no two in one row or column of the 16 x 16 that it is cut into.
//
// Invariants
//   A place on an edge belongs to one of the two polygons that share it.
// Consequences
//   Triangles of a closed surface cover each place as often as a ray there meets the surface.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace octavo {

/// A corner in pixels from the upper left corner of the picture.
struct ScreenPoint {
  double x = 0;
  double y = 0;
};

inline constexpr int kPlacesInPixel = 16;

/// Places in a pixel, in 1/256 of it.
struct PixelPlaces {
  std::array<std::int32_t, kPlacesInPixel> x{};
  std::array<std::int32_t, kPlacesInPixel> y{};
};

/// Rows are those of Hammersley's set.
constexpr PixelPlaces make_pixel_places() {
  PixelPlaces places;
  for (int i = 0; i < kPlacesInPixel; ++i) {
    const int mirrored = (i & 1) << 3 | (i & 2) << 1 | (i & 4) >> 1 | (i & 8) >> 3;
    places.x[static_cast<std::size_t>(i)] = 8 + 16 * i;
    places.y[static_cast<std::size_t>(i)] = 8 + 16 * mirrored;
  }
  return places;
}

inline constexpr PixelPlaces kPixelPlaces = make_pixel_places();

/// No corner may lie farther from the picture, pixels.
inline constexpr double kFarthestCorner = 1 << 20;

/// Pixels from (left, top) on, `side` of them each way.
struct PixelSquare {
  std::int64_t left = 0;
  std::int64_t top = 0;
  std::int64_t side = 0;
};

/// Calls visit(column, row, mask) for each pixel of a square in which a polygon covers places; bit
/// i of the mask is place i. Column and row count from the corner of the square.
/// corners  of a convex polygon, either way round
template <class Visit>
void visit_covered(std::span<const ScreenPoint> corners, const PixelSquare& square, Visit&& visit);

/// The edges of a polygon, in 1/256 of a pixel.
class PolygonEdges {
 public:
  static constexpr std::size_t kMostCorners = 8;

  /// Requires 3 to kMostCorners corners.
  explicit PolygonEdges(std::span<const ScreenPoint> corners);

  bool has_area() const { return has_area_; }
  /// Pixels that it may cover: [low, high).
  std::array<std::int64_t, 2> columns() const;
  std::array<std::int64_t, 2> rows() const;
  /// The places that it covers of a pixel.
  std::uint32_t mask(std::int64_t column, std::int64_t row) const;

 private:
  struct Edge {
    std::int64_t across = 0;  // inside, across * x + down * y + offset is 0 or more
    std::int64_t down = 0;
    std::int64_t offset = 0;
    std::int64_t reach = 0;  // how much it differs within a pixel from its middle
  };

  std::array<Edge, kMostCorners> edges_;
  std::size_t count_ = 0;
  bool has_area_ = false;
  std::array<std::int64_t, 2> low_{};
  std::array<std::int64_t, 2> high_{};
};

template <class Visit>
void visit_covered(std::span<const ScreenPoint> corners, const PixelSquare& square,
                   Visit&& visit) {
  const PolygonEdges polygon(corners);
  if (!polygon.has_area()) return;
  const auto [left, right] = polygon.columns();
  const auto [top, bottom] = polygon.rows();
  const std::int64_t first_row = top > square.top ? top - square.top : 0;
  const std::int64_t first_column = left > square.left ? left - square.left : 0;
  for (std::int64_t row = first_row; row < square.side && row + square.top < bottom; ++row) {
    for (std::int64_t column = first_column;
         column < square.side && column + square.left < right; ++column) {
      const std::uint32_t mask = polygon.mask(column + square.left, row + square.top);
      if (mask != 0) visit(column, row, mask);
    }
  }
}

}  // namespace octavo
