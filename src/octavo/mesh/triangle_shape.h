// How the triangles around a point may change while a surface gets fewer of them.
//
// Where a surface passes a grid point closely, the points around it lie so near to one another that
// the triangles between them have no side that means anything, and long ones are slivers. What such
// triangles become is held against the side of the whole star, and slivers may stay that are no
// worse than before: otherwise nothing around them could ever be collapsed.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

/// A triangle's normal, as long as twice its area, and its longest side, squared.
struct TriangleShape {
  Point3 normal;
  double longest = 0;

  explicit TriangleShape(const TrianglePlaces& t) {
    const Point3 ab = difference(t[1], t[0]);
    const Point3 ac = difference(t[2], t[0]);
    const Point3 bc = difference(t[2], t[1]);
    normal = cross(ab, ac);
    longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  }

  double squared_normal() const { return dot(normal, normal); }
  bool is_lower_than(double height) const {
    return squared_normal() < height * height * longest;
  }
};

class ShapeRule {
 public:
  /// tolerance  how far the surface may move
  explicit ShapeRule(double tolerance) : negligible_(tolerance / 32) {}

  /// Whether one triangle of a star may become another one.
  /// around   called for the sum of the normals of the star before
  /// Returns  the unit normal of what it becomes; nothing where it may not
  template <class Around>
  std::optional<Point3> renewed(const TrianglePlaces& before, const TrianglePlaces& after,
                                Around&& around) const {
    constexpr double kSmallestCosine = 0.2;
    constexpr double kSliver = 1e-4;  // squared: a height of 1/100 of the longest side
    constexpr double kLine = 1e-12;
    const TriangleShape old(before);
    const TriangleShape now(after);
    const double squared = now.squared_normal();
    const bool was_flat = old.is_lower_than(negligible_);
    const double thinnest = was_flat ? kLine : kSliver;
    if (squared <= thinnest * now.longest * now.longest) return std::nullopt;
    if (!was_flat || !now.is_lower_than(negligible_)) {
      const Point3 side = was_flat ? around() : old.normal;
      const double cosine = dot(side, now.normal);
      const double smallest = kSmallestCosine * kSmallestCosine * dot(side, side) * squared;
      if (cosine <= 0 || cosine * cosine < smallest) return std::nullopt;
    }
    return scaled(now.normal, 1 / std::sqrt(squared));
  }

 private:
  double negligible_;
};

}  // namespace octavo
