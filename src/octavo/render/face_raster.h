// Faces of voxel cubes on a grid of pixels, exactly.
//
// A pixel belongs to a face when its centre, moved to the right by an infinitely small step and
// down by one infinitely smaller still, lies inside. With corners that are whole numbers of units
// this is decided without rounding:
//
//     rows      top.y <= centre < bottom.y
//     columns   left crossing <= centre < right crossing of the row, as fractions
//
// Consequences
//   Faces that share an edge, of cubes of any sizes, neither leave a pixel out nor both take it.
//   The faces of a cube that are turned to the viewer cover its outline, each pixel once; what lies
//   behind a cube, wholly within its outline, is overdrawn to the last pixel.
#pragma once

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
  int axis = 0;          ///< the index axis it is across
  PlanePoint top;        ///< from the place of the cube's lowest corner
  PlanePoint left;
  PlanePoint right;
  std::int64_t depth = 0;   ///< of its middle
  double left_slope = 0;    ///< x by y
  double right_slope = 0;
};

/// The faces of a cube that are turned to the viewer, and its bounds.
struct CubeShape {
  std::array<Face, 3> faces;
  int face_count = 0;
  PlanePoint lowest;   ///< from the place of the lowest corner
  PlanePoint highest;
};

/// The shape of cubes of side 2^level.
CubeShape cube_shape(const View& view, int level);

/// Some rows of a picture, 32 bits a pixel.
class PixelRows {
 public:
  /// Rows begin .. end - 1 of the view's picture, all of `pixel`.
  PixelRows(const View& view, std::int64_t begin, std::int64_t end, std::uint32_t pixel);

  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return end_; }
  const std::uint32_t* row(std::int64_t y) const { return pixels_.data() + (y - begin_) * width_; }

  /// Whether no pixel centre here is in the outline's box of a cube.
  bool misses(const CubeShape& shape, const Place& corner) const {
    return corner.y + shape.highest.y <= first_centre_y_ ||
           corner.y + shape.lowest.y > last_centre_y_ ||
           corner.x + shape.highest.x <= first_centre_x_ ||
           corner.x + shape.lowest.x > last_centre_x_;
  }

  /// Gives the pixels of a face of the cube at `corner` a colour.
  void fill(const Face& face, const Place& corner, std::uint32_t pixel);

 private:
  // The first pixel centre at or beyond a coordinate.
  std::int64_t pixel_from(std::int64_t units) const { return (units + half_ - 1) >> bits_; }
  // The same for the place where a line from `from` along `edge` crosses the row with this centre.
  std::int64_t crossing(const PlanePoint& from, const PlanePoint& edge, double slope,
                        std::int64_t centre) const;

  std::int64_t width_;
  std::int64_t begin_;
  std::int64_t end_;
  int bits_;
  std::int64_t half_;
  double pixels_per_unit_;
  double doubt_;  // pixels: a crossing this close to a centre needs exact division
  std::int64_t first_centre_x_;
  std::int64_t last_centre_x_;
  std::int64_t first_centre_y_;
  std::int64_t last_centre_y_;
  std::vector<std::uint32_t> pixels_;
};

}  // namespace octavo
