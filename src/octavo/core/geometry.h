// Where the voxels of a grid lie in the patient or specimen.
#pragma once

#include <array>

#include "octavo/core/box.h"

namespace octavo {

using Point3 = std::array<double, 3>;

/// Voxel-center geometry with ITK's meanings: LPS, millimeters.
/// world = origin + direction * (spacing .* index), index counting voxel centers from 0.
struct Geometry {
  Point3 origin_mm = {0, 0, 0};
  Point3 spacing_mm = {1, 1, 1};
  /// Row-major; column a is the unit vector of index axis a.
  std::array<double, 9> direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};

  bool operator==(const Geometry&) const = default;

  /// The world position of a (possibly fractional) voxel index [x, y, z].
  Point3 to_world(const Point3& index) const;

  /// The fractional voxel index of a world position.
  /// Requires a direction with a determinant other than 0.
  Point3 to_index(const Point3& world_mm) const;
};

inline constexpr double kMinSpacingMm = 1e-9;
inline constexpr double kMaxSpacingMm = 1e9;
inline constexpr double kMaxOriginMm = 1e12;

/// True when spacings and origin lie within their limits, all numbers are finite and the direction
/// is invertible.
bool is_valid(const Geometry& geometry) noexcept;

/// How far axes may be from unit length, and the cosine between two of them from 0, for a grid to
/// count as one of perpendicular unit axes.
inline constexpr double kAxisTolerance = 1e-3;

/// The same for the length of an axis in a file.
inline constexpr double kStoredAxisTolerance = 1e-4;

/// True when every column of the direction has length 1 within `tolerance`.
bool has_unit_axes(const Geometry& geometry, double tolerance = kAxisTolerance) noexcept;

/// The geometry with every column of the direction made as long as 1. Requires a valid one.
Geometry with_unit_axes(const Geometry& geometry) noexcept;

/// The length of column `axis` of the direction.
double axis_length(const Geometry& geometry, std::size_t axis) noexcept;

/// The cosine of the angle between two index axes; not a number where one has no length.
double axis_cosine(const Geometry& geometry, std::size_t a, std::size_t b) noexcept;

/// The geometry of the sub-grid that starts at voxel `start`.
Geometry cropped(const Geometry& geometry, const Index3& start);

}  // namespace octavo
