// A flat cut through a volume: the pixels of a picture as places in space.
//
// A slice of the grid and an oblique plane are the same thing here, a map from pixels to places
// that is linear:
//
//     place of pixel (x, y)  =  origin + x * across + y * down       mm, LPS
//
// Composed with the geometry of any volume it says where a pixel lies in that volume's grid, so
// that volumes on different grids are drawn over each other.
#pragma once

#include <cstdint>

#include "octavo/core/geometry.h"
#include "octavo/render/view.h"

namespace octavo {

/// Places of pixels, in world or index space.
struct PixelMap {
  Point3 origin{};  ///< of pixel (0, 0)
  Point3 across{};  ///< from a pixel to the next of its row
  Point3 down{};    ///< from a pixel to the one below

  Point3 at(double x, double y) const {
    return {origin[0] + x * across[0] + y * down[0], origin[1] + x * across[1] + y * down[1],
            origin[2] + x * across[2] + y * down[2]};
  }
};

/// Square pixels in space.
struct PlaneSection {
  std::int64_t width = 0;
  std::int64_t height = 0;
  double pixel_mm = 1;  ///< side of a pixel; pixels are square
  PixelMap world;
  EdgeLetters letters;  ///< the patient's sides at the edges
};

/// A plane through world space.
struct CutPlane {
  Point3 point_mm{};
  Point3 normal{};  ///< of any length but 0
};

/// The pixels of a slice of a grid of `size`, across index axis `axis`; its index axes become
/// picture axes as slice_orientation.h says. Pixels are as fine as the finer spacing, and finer by
/// a whole factor where the longer side would have fewer than `minimum_side` pixels.
/// Throws Error{invalid_argument} on an axis or index that is not there, and on spacings so
///        different that a side has more than 2^28 pixels
PlaneSection axis_section(const Geometry& geometry, const Size3& size, int axis, std::int64_t index,
                     std::int64_t minimum_side);

/// The pixels of the part of a plane that lies in a grid of `size`. The picture is upright and seen
/// as a slice would be that is nearest to the plane: from the feet, from the front or from the
/// left. Pixels are as fine as the finest spacing, and finer as for axis_section.
/// Throws Error{invalid_argument} on a normal that is 0 or not finite, where the plane does not
///        meet the grid, and on spacings as for axis_section
PlaneSection oblique_section(const Geometry& geometry, const Size3& size, const CutPlane& plane,
                        std::int64_t minimum_side);

/// Where pixels lie in a grid: fractional indices. What is a whole index but for rounding is one.
PixelMap index_map(const PixelMap& world, const Geometry& geometry);

}  // namespace octavo
