// Polygons of any shape as triangles.
//
// What turns left at every corner becomes a fan around the first one. Of others, also of those with
// a straight corner, whose fan could have a triangle without area, ears are cut off one after the
// other: corners whose triangle lies inside and holds no other corner.
//
//     1---2        A fan around 1 would have the triangle 1 4 5, outside the polygon:
//     | 4 |        the dent at 4 belongs to none of its own. The ears are 2 and 5.
//     |/ \|
//     5   3
//
// Invariants
//   n corners give n - 2 triangles that turn as the polygon does, and each side of the polygon is
//   one of theirs.
//   Polygons that are not flat are seen along their normal, the sum of cross products of sides.
//   What crosses itself has no right answer: where no ear is left the rest is a fan.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// A corner as it is seen along the normal of its polygon.
struct FlatPoint {
  double x = 0;
  double y = 0;

  bool operator==(const FlatPoint&) const = default;
};

/// Cuts polygons one after the other, in memory that it keeps: what turns left at every corner
/// takes none of its own.
class PolygonCutter {
 public:
  /// The triangles of a polygon, until the next is cut.
  /// corners  numbers of points; fewer than three give nothing
  /// Throws Error{limit_exceeded} on one that is not convex with more than 2^16 corners, or winds
  ///        so much that each of its corners would be compared with thousands of others
  std::span<const MeshTriangle> cut(std::span<const MeshPoint> points,
                                    std::span<const std::uint32_t> corners);

 private:
  bool see_along_normal(std::span<const MeshPoint> points,
                        std::span<const std::uint32_t> corners);

  std::vector<FlatPoint> flat_;
  std::vector<MeshTriangle> triangles_;
};

}  // namespace octavo
