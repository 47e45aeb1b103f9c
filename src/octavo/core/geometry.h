// Where the voxels of a grid lie in the patient or specimen.
#pragma once

#include <array>

#include "octavo/core/box.h"

namespace octavo {

using Point3 = std::array<double, 3>;

/// Voxel-centre geometry with ITK's meanings: LPS, millimetres.
/// world = origin + direction * (spacing .* index), index counting voxel centres from 0.
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

/// True when spacings are finite and positive, all numbers finite and the direction invertible.
bool is_valid(const Geometry& geometry) noexcept;

/// The geometry of the sub-grid that starts at voxel `start`.
Geometry cropped(const Geometry& geometry, const Index3& start);

}  // namespace octavo
