// Rotations by quarter turns and mirrors of a grid: its axes in another order, some backwards.
//
// There are 48 of them; each moves whole voxels to whole voxels, so nothing is interpolated.
#pragma once

#include <array>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"

namespace octavo {

/// Axis a of the turned grid runs along axis from[a] of the source, backwards where
/// is_reversed[a].
struct AxisTurn {
  std::array<int, 3> from = {0, 1, 2};
  std::array<bool, 3> is_reversed = {false, false, false};

  bool operator==(const AxisTurn&) const = default;
};

/// `count` quarter turns about an index axis (0 = x), right-handed in index space: one about z
/// moves what lies along x to lie along y. Negative ones turn back.
AxisTurn quarter_turns(int axis, int count);

/// The grid backwards along one axis.
AxisTurn mirror_along(int axis);

/// `first`, and then `second` on what came of it.
AxisTurn chained(const AxisTurn& first, const AxisTurn& second);

/// The size of a turned grid.
Size3 turned(const Size3& size, const AxisTurn& turn);

/// The source voxel that comes to stand at `voxel` of the turned grid.
/// size  of the source
Index3 source_of(const Index3& voxel, const Size3& size, const AxisTurn& turn);

/// The geometry with which every voxel keeps its place in space: the axes of the grid turn, the
/// object stays. A mirror gives a left-handed direction.
/// size  of the source
Geometry turned(const Geometry& geometry, const Size3& size, const AxisTurn& turn);

/// The geometry with which the object turns about the center of the grid: the direction stays, the
/// spacing follows the voxels.
/// size  of the source
Geometry turned_object(const Geometry& geometry, const Size3& size, const AxisTurn& turn);

/// The geometry of a grid of `size` and `spacing_mm` with the direction and the center of another.
Geometry recentered(const Geometry& geometry, const Size3& old_size, const Size3& size,
                   const Point3& spacing_mm);

}  // namespace octavo
