// Maps of space onto itself that keep lines straight: a matrix and an offset.
#pragma once

#include <array>
#include <optional>

#include "octavo/core/geometry.h"
#include "octavo/ops/grid/axis_turn.h"

namespace octavo {

/// p becomes linear * p + offset.
struct Affine {
  std::array<double, 9> linear = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major
  Point3 offset = {0, 0, 0};

  bool operator==(const Affine&) const = default;
  Point3 operator()(const Point3& p) const;
};

/// `first`, and then `second` on what came of it.
Affine chained(const Affine& first, const Affine& second);

/// The map back; nothing where the map is flat or not finite.
std::optional<Affine> inverse(const Affine& map);

/// From voxel indices to mm in world space.
Affine index_to_world(const Geometry& geometry);

/// Whether any voxel of a grid may lie in a source; false only where none does.
/// to_source  from voxel indices of the grid to those of the source
bool may_meet(const Affine& to_source, const Size3& grid, const Size3& source);

/// From voxels of a turned grid to those of the source.
/// size  of the source
Affine to_source(const AxisTurn& turn, const Size3& size);

}  // namespace octavo
