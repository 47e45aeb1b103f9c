#include "octavo/core/geometry.h"

#include <cmath>

namespace octavo {

namespace {

double determinant(const std::array<double, 9>& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
         m[2] * (m[3] * m[7] - m[4] * m[6]);
}

double dot_of_axes(const std::array<double, 9>& m, std::size_t a, std::size_t b) {
  return m[a] * m[b] + m[3 + a] * m[3 + b] + m[6 + a] * m[6 + b];
}

}  // namespace

Point3 Geometry::to_world(const Point3& index) const {
  Point3 world = origin_mm;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      world[row] += direction[row * 3 + axis] * spacing_mm[axis] * index[axis];
    }
  }
  return world;
}

Point3 Geometry::to_index(const Point3& world_mm) const {
  // Cramer's rule on direction * u = world - origin.
  const std::array<double, 9>& m = direction;
  const double det = determinant(m);
  Point3 index{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<double, 9> replaced = m;
    for (std::size_t row = 0; row < 3; ++row) {
      replaced[row * 3 + axis] = world_mm[row] - origin_mm[row];
    }
    index[axis] = determinant(replaced) / det / spacing_mm[axis];
  }
  return index;
}

bool is_valid(const Geometry& geometry) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double spacing = geometry.spacing_mm[axis];
    if (!(std::abs(geometry.origin_mm[axis]) <= kMaxOriginMm)) return false;
    if (!(spacing >= kMinSpacingMm && spacing <= kMaxSpacingMm)) return false;
  }
  for (const double v : geometry.direction) {
    if (!std::isfinite(v)) return false;
  }
  return std::abs(determinant(geometry.direction)) > 1e-6;
}

bool has_unit_axes(const Geometry& geometry, double tolerance) noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(std::abs(axis_length(geometry, axis) - 1) <= tolerance)) return false;
  }
  return true;
}

Geometry with_unit_axes(const Geometry& geometry) noexcept {
  Geometry result = geometry;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = axis_length(geometry, axis);
    for (std::size_t row = 0; row < 3; ++row) result.direction[3 * row + axis] /= length;
  }
  return result;
}

double axis_length(const Geometry& geometry, std::size_t axis) noexcept {
  return std::sqrt(dot_of_axes(geometry.direction, axis, axis));
}

double axis_cosine(const Geometry& geometry, std::size_t a, std::size_t b) noexcept {
  return dot_of_axes(geometry.direction, a, b) /
         (axis_length(geometry, a) * axis_length(geometry, b));
}

Geometry cropped(const Geometry& geometry, const Index3& start) {
  Geometry result = geometry;
  result.origin_mm =
      geometry.to_world({static_cast<double>(start.x), static_cast<double>(start.y),
                         static_cast<double>(start.z)});
  return result;
}

}  // namespace octavo
