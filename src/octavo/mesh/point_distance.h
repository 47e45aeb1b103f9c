// How far a place is from a triangle.
#pragma once

#include <algorithm>

#include "octavo/core/triangle_mesh.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/triangle_crossing.h"

namespace octavo {

inline Point3 place_of_point(const MeshPoint& point) { return {point[0], point[1], point[2]}; }

inline TrianglePlaces places_of(const TriangleMesh& mesh, const MeshTriangle& t) {
  return {place_of_point(mesh.points[t[0]]), place_of_point(mesh.points[t[1]]),
          place_of_point(mesh.points[t[2]])};
}

/// Source  Ericson, Real-time collision detection, 2005, 5.1.5
inline double squared_distance(const Point3& p, const TrianglePlaces& t) {
  const auto squared = [](const Point3& v) { return dot(v, v); };
  const Point3 ab = difference(t[1], t[0]);
  const Point3 ac = difference(t[2], t[0]);

  // Beyond a corner
  const Point3 ap = difference(p, t[0]);
  const double ab_ap = dot(ab, ap);
  const double ac_ap = dot(ac, ap);
  if (ab_ap <= 0 && ac_ap <= 0) return squared(ap);
  const Point3 bp = difference(p, t[1]);
  const double ab_bp = dot(ab, bp);
  const double ac_bp = dot(ac, bp);
  if (ab_bp >= 0 && ac_bp <= ab_bp) return squared(bp);
  const Point3 cp = difference(p, t[2]);
  const double ab_cp = dot(ab, cp);
  const double ac_cp = dot(ac, cp);
  if (ac_cp >= 0 && ab_cp <= ac_cp) return squared(cp);

  // Beyond a side
  const double c = ab_ap * ac_bp - ab_bp * ac_ap;
  if (c <= 0 && ab_ap >= 0 && ab_bp <= 0) {
    return squared(difference(ap, scaled(ab, ab_ap / (ab_ap - ab_bp))));
  }
  const double b = ab_cp * ac_ap - ab_ap * ac_cp;
  if (b <= 0 && ac_ap >= 0 && ac_cp <= 0) {
    return squared(difference(ap, scaled(ac, ac_ap / (ac_ap - ac_cp))));
  }
  const double a = ab_bp * ac_cp - ab_cp * ac_bp;
  const double along = ac_bp - ab_bp;
  const double against = ab_cp - ac_cp;
  if (a <= 0 && along >= 0 && against >= 0) {
    return squared(
        difference(bp, scaled(difference(t[2], t[1]), along / (along + against))));
  }

  // Above the triangle
  const double sum = a + b + c;
  if (!(sum > 0)) return std::min({squared(ap), squared(bp), squared(cp)});
  return squared(difference(ap, octavo::sum(scaled(ab, b / sum), scaled(ac, c / sum))));
}

}  // namespace octavo
