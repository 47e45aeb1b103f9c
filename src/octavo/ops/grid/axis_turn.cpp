#include "octavo/ops/grid/axis_turn.h"

namespace octavo {

namespace {

std::size_t axis_index(int axis) { return static_cast<std::size_t>(axis); }

Point3 center_of(const Size3& size) {
  return {static_cast<double>(size.x - 1) / 2, static_cast<double>(size.y - 1) / 2,
          static_cast<double>(size.z - 1) / 2};
}

}  // namespace

AxisTurn quarter_turns(int axis, int count) {
  // What lies along u comes to lie along v, what lies along v backwards along u.
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  AxisTurn quarter;
  quarter.from[axis_index(v)] = u;
  quarter.from[axis_index(u)] = v;
  quarter.is_reversed[axis_index(u)] = true;
  AxisTurn turn;
  for (int i = ((count % 4) + 4) % 4; i > 0; --i) turn = chained(turn, quarter);
  return turn;
}

AxisTurn mirror_along(int axis) {
  AxisTurn turn;
  turn.is_reversed[axis_index(axis)] = true;
  return turn;
}

AxisTurn chained(const AxisTurn& first, const AxisTurn& second) {
  AxisTurn both;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t between = axis_index(second.from[a]);
    both.from[a] = first.from[between];
    both.is_reversed[a] = first.is_reversed[between] != second.is_reversed[a];
  }
  return both;
}

Size3 turned(const Size3& size, const AxisTurn& turn) {
  return {size[turn.from[0]], size[turn.from[1]], size[turn.from[2]]};
}

Index3 source_of(const Index3& voxel, const Size3& size, const AxisTurn& turn) {
  Index3 source;
  for (int a = 0; a < 3; ++a) {
    const int from = turn.from[axis_index(a)];
    source[from] = turn.is_reversed[axis_index(a)] ? size[from] - 1 - voxel[a] : voxel[a];
  }
  return source;
}

Geometry turned(const Geometry& geometry, const Size3& size, const AxisTurn& turn) {
  const Index3 first = source_of({0, 0, 0}, size, turn);
  Geometry result = cropped(geometry, first);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t from = axis_index(turn.from[a]);
    result.spacing_mm[a] = geometry.spacing_mm[from];
    for (std::size_t row = 0; row < 3; ++row) {
      const double part = geometry.direction[3 * row + from];
      // 0 - part: a zero stays +0.
      result.direction[3 * row + a] = turn.is_reversed[a] ? 0 - part : part;
    }
  }
  return result;
}

Geometry turned_object(const Geometry& geometry, const Size3& size, const AxisTurn& turn) {
  Point3 spacing{};
  for (std::size_t a = 0; a < 3; ++a) spacing[a] = geometry.spacing_mm[axis_index(turn.from[a])];
  return recentered(geometry, size, turned(size, turn), spacing);
}

Geometry recentered(const Geometry& geometry, const Size3& old_size, const Size3& size,
                   const Point3& spacing_mm) {
  const Point3 center = geometry.to_world(center_of(old_size));
  Geometry result = geometry;
  result.spacing_mm = spacing_mm;
  result.origin_mm = {0, 0, 0};
  const Point3 half = result.to_world(center_of(size));
  for (std::size_t row = 0; row < 3; ++row) result.origin_mm[row] = center[row] - half[row];
  return result;
}

}  // namespace octavo
