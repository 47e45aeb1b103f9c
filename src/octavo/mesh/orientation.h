// On which side of a plane, or of a line, a point lies: answers that are never wrong.
//
// A determinant in double precision whose size passes a bound on its rounding errors decides at
// once. The few others are computed again as expansions, sums of doubles that do not overlap, whose
// sign is exact.
//
// Source  Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric
//         predicates, 1997
#pragma once

#include "octavo/core/geometry.h"

namespace octavo {

/// 1 where d lies below the plane of a, b, c, seen from where these turn counterclockwise; -1
/// above, 0 on it. Exact for coordinates that are floats.
int orientation_of(const Point3& a, const Point3& b, const Point3& c, const Point3& d);

/// 1 where a, b, c turn counterclockwise in the plane of the axes u and v; -1 clockwise, 0 on a
/// line. Exact for coordinates that are floats.
int turn_of(const Point3& a, const Point3& b, const Point3& c, int u, int v);

}  // namespace octavo
