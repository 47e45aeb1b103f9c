// Arithmetic of vectors in space.
#pragma once

#include <cmath>

#include "octavo/core/geometry.h"

namespace octavo {

inline double dot(const Point3& a, const Point3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Point3 cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Point3 scaled(const Point3& a, double by) { return {a[0] * by, a[1] * by, a[2] * by}; }

inline Point3 sum(const Point3& a, const Point3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline Point3 difference(const Point3& a, const Point3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// `a` with a length of 1. Requires that it has one.
inline Point3 unit(const Point3& a) { return scaled(a, 1 / std::sqrt(dot(a, a))); }

}  // namespace octavo
