// Faces of voxel cubes on a grid of pixels, exactly.
//
// A pixel belongs to a face when its center, moved to the right by an infinitely small step and
// down by one infinitely smaller still, lies inside. With corners that are whole numbers of units
// this is decided without rounding:
//
//     rows      top.y <= center < bottom.y
//     columns   left crossing <= center < right crossing of the row, as fractions
//
// Consequences
//   Faces that share an edge, of cubes of any sizes, neither leave a pixel out nor both take it.
//   The faces of a cube that are turned to the viewer cover its outline, each pixel once; what lies
//   behind a cube, wholly within its outline, is overdrawn to the last pixel.
//   A cube whose outline is thinner than the diagonal of a pixel may lie between all centers. So
//   that it does not vanish it has a spine as well: the pixels along its middle.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "octavo/render/view.h"

namespace octavo {

/// A corner or an edge in the picture, in units of the view.
struct PlanePoint {
  std::int64_t x = 0;
  std::int64_t y = 0;
};

/// A parallelogram that stands on its lowest point:
///
///            top               left and right lead down from the top, and right of each other;
///      left /   \ right        right may be level
///          /     \ .
///          \     /
struct Face {
  int axis = 0;    ///< the index axis it is across
  PlanePoint top;  ///< from the place of the cube's lowest corner
  PlanePoint left;
  PlanePoint right;
  std::int64_t depth = 0;  ///< of its middle
  double left_slope = 0;   ///< x by y
  double right_slope = 0;

  double area() const {  ///< square units
    return static_cast<double>(right.x) * static_cast<double>(left.y) -
           static_cast<double>(left.x) * static_cast<double>(right.y);
  }
};

/// The faces of a cube that are turned to the viewer, and its bounds.
struct CubeShape {
  std::array<Face, 3> faces;
  int face_count = 0;
  PlanePoint lowest;  ///< from the place of the lowest corner
  PlanePoint highest;
  /// Places at most a pixel apart from end to end of a thin outline, from the place of the lowest
  /// corner; none where it is wide enough to hold the center of a pixel wherever it lies.
  std::vector<PlanePoint> spine;

  /// The largest of the faces whose axes have a bit in `axes`, which has one.
  const Face& largest_face(unsigned axes) const;
};

/// The shape of cubes of side 2^level.
CubeShape cube_shape(const View& view, int level);

/// Columns left .. right - 1 of rows top .. bottom - 1.
struct PixelBox {
  std::int64_t left = 0;
  std::int64_t right = 0;
  std::int64_t top = 0;
  std::int64_t bottom = 0;

  bool is_empty() const { return left >= right || top >= bottom; }
};

/// Some rows of a picture, 32 bits a pixel.
class PixelRows {
 public:
  /// Rows begin .. end - 1 of the view's picture, all of `pixel`.
  /// has_spines  cubes take pixels that they touch besides those whose centers they hold
  PixelRows(const View& view, std::int64_t begin, std::int64_t end, std::uint32_t pixel,
            bool has_spines = false);

  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }
  std::int64_t width() const { return width_; }
  const std::uint32_t* row(std::int64_t y) const { return pixels_.data() + (y - begin_) * width_; }
  std::uint32_t* row(std::int64_t y) { return pixels_.data() + (y - begin_) * width_; }

  /// Whether no pixel here that a cube could take is in the box of its outline.
  bool misses(const CubeShape& shape, const Place& corner) const {
    return pixels_of(shape, corner).is_empty();
  }

  /// The pixels here whose centers lie in the outline's box of a cube; with spines those that it
  /// touches.
  PixelBox pixels_of(const CubeShape& shape, const Place& corner) const {
    return {std::max<std::int64_t>(0, pixel_from(corner.x + shape.lowest.x - below_)),
            std::min(width_, pixel_from(corner.x + shape.highest.x + above_)),
            std::max(begin_, pixel_from(corner.y + shape.lowest.y - below_)),
            std::min(end_, pixel_from(corner.y + shape.highest.y + above_))};
  }

  /// Calls take(y, left, right) for the rows of a face of the cube at `corner`: columns from left
  /// to right - 1, none when left is not below right.
  template <class Take>
  void for_each_run(const Face& face, const Place& corner, Take take) const;

  /// Gives the pixels of a face of the cube at `corner` a color.
  void fill(const Face& face, const Place& corner, std::uint32_t pixel) {
    for_each_run(face, corner, [&](std::int64_t y, std::int64_t left, std::int64_t right) {
      std::uint32_t* const to = row(y);
      for (std::int64_t x = left; x < right; ++x) to[x] = pixel;
    });
  }

  /// Calls take(y, x) for the pixels here along the spine of the cube at `corner`.
  template <class Take>
  void for_each_spine_pixel(const CubeShape& shape, const Place& corner, Take take) const {
    for (const PlanePoint& point : shape.spine) {
      const std::int64_t x = (corner.x + point.x) >> bits_;
      const std::int64_t y = (corner.y + point.y) >> bits_;
      if (x >= 0 && x < width_ && y >= begin_ && y < end_) take(y, x);
    }
  }

 private:
  // The first pixel center at or beyond a coordinate.
  std::int64_t pixel_from(std::int64_t units) const { return (units + half_ - 1) >> bits_; }
  // The same for the place where a line from `from` along `edge` crosses the row with this center.
  std::int64_t crossing(const PlanePoint& from, const PlanePoint& edge, double slope,
                        std::int64_t center) const;
  std::int64_t exact_crossing(const PlanePoint& from, const PlanePoint& edge,
                              std::int64_t down) const;

  std::int64_t width_;
  std::int64_t begin_;
  std::int64_t end_;
  int bits_;
  std::int64_t half_;
  std::int64_t below_ = 0;  // how far before and behind a center an outline takes its pixel
  std::int64_t above_ = 0;
  double pixels_per_unit_;
  double doubt_;  // pixels: a crossing this close to a center needs exact division
  std::vector<std::uint32_t> pixels_;
};

inline std::int64_t PixelRows::crossing(const PlanePoint& from, const PlanePoint& edge,
                                        double slope, std::int64_t center) const {
  const std::int64_t down = center - from.y;
  const double x = static_cast<double>(from.x - half_) + static_cast<double>(down) * slope;
  const double pixels = x * pixels_per_unit_;
  const auto below = static_cast<std::int64_t>(pixels);
  const std::int64_t pixel = below + (pixels > static_cast<double>(below) ? 1 : 0);
  // A crossing so close to a pixel center that rounding may have moved it is divided exactly.
  const double short_of = static_cast<double>(pixel) - pixels;
  if (short_of > doubt_ && short_of < 1 - doubt_) return pixel;
  return exact_crossing(from, edge, down);
}

template <class Take>
void PixelRows::for_each_run(const Face& face, const Place& corner, Take take) const {
  const PlanePoint top{face.top.x + corner.x, face.top.y + corner.y};
  const PlanePoint at_left{top.x + face.left.x, top.y + face.left.y};
  const PlanePoint at_right{top.x + face.right.x, top.y + face.right.y};
  const std::int64_t begin = std::max(begin_, pixel_from(top.y));
  const std::int64_t end = std::min(end_, pixel_from(at_left.y + face.right.y));
  for (std::int64_t y = begin; y < end; ++y) {
    const std::int64_t center = (y << bits_) + half_;
    const std::int64_t left = center < at_left.y
                                  ? crossing(top, face.left, face.left_slope, center)
                                  : crossing(at_left, face.right, face.right_slope, center);
    const std::int64_t right = center < at_right.y
                                   ? crossing(top, face.right, face.right_slope, center)
                                   : crossing(at_right, face.left, face.left_slope, center);
    take(y, std::max<std::int64_t>(left, 0), std::min(right, width_));
  }
}

}  // namespace octavo
