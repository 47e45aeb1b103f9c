// Rotations of a grid by any angle, about any axis, and mirrors: lengths stay what they are.
//
// Axes and angles are those of the grid: x, y and z are its index axes, lengths count in mm. So a
// rotation turns no sphere into an ellipsoid, whatever the spacing.
//
//     R  new = R * old, from the center of the grid, mm along its axes
//
// A rotation that takes every axis onto an axis is one of the 48 turns of axis_turn.h and moves
// whole voxels; values are interpolated by all others.
#pragma once

#include <array>
#include <optional>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/ops/grid/affine.h"
#include "octavo/ops/grid/axis_turn.h"

namespace octavo {

/// Row-major and orthogonal; a mirror has determinant -1.
using Rotation = std::array<double, 9>;

inline constexpr Rotation kNoRotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/// The rotation about `axis`, right-handed: one about z moves what lies along x towards y. By whole
/// quarters about an axis of the grid it is exact.
/// axis  of any length but 0
Rotation rotation_about(const Point3& axis, double degrees);

/// The turn as a rotation.
Rotation rotation_of(const AxisTurn& turn);

/// `first`, and then `second` on what came of it.
Rotation chained(const Rotation& first, const Rotation& second);

/// The turn that a rotation is, up to rounding; nothing where it is none.
std::optional<AxisTurn> as_turn(const Rotation& rotation);

/// A grid with its voxels turned.
struct TurnedGrid {
  Size3 size;
  Geometry geometry;
  Affine to_source;  ///< from its voxels to those of the grid that was turned
};

/// The grid that holds a volume turned about its center. Its spacing is that of the nearest quarter
/// turns, and it is as large as the turned volume is. Unless the rotation is a turn, its corners
/// lie outside the source.
/// is_in_place  the direction stays and the object turns; otherwise the axes of the grid turn, and
///              every voxel keeps its place in space
TurnedGrid turned_grid(const Geometry& geometry, const Size3& size, const Rotation& rotation,
                       bool is_in_place);

}  // namespace octavo
