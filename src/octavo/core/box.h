// Sizes, indices and half-open boxes on a voxel grid.
#pragma once

#include <algorithm>
#include <cstdint>

namespace octavo {

/// A position on a voxel grid, x fastest.
struct Index3 {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;

  bool operator==(const Index3&) const = default;
  std::int64_t& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  std::int64_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

/// Samples per axis. A size that came from outside is proven by `checked_voxel_count` first.
struct Size3 {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;

  bool operator==(const Size3&) const = default;
  std::int64_t& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
  std::int64_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  std::int64_t voxel_count() const { return x * y * z; }
};

/// Half-open: lo is inside, hi is not.
struct Box {
  Index3 lo;
  Index3 hi;

  bool operator==(const Box&) const = default;
  Size3 size() const { return {hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}; }
  bool is_empty() const { return hi.x <= lo.x || hi.y <= lo.y || hi.z <= lo.z; }
  bool contains(const Index3& p) const {
    return p.x >= lo.x && p.x < hi.x && p.y >= lo.y && p.y < hi.y && p.z >= lo.z && p.z < hi.z;
  }
  bool contains(const Box& b) const {
    return b.lo.x >= lo.x && b.hi.x <= hi.x && b.lo.y >= lo.y && b.hi.y <= hi.y && b.lo.z >= lo.z &&
           b.hi.z <= hi.z;
  }
};

/// The box of a whole grid.
inline Box box_of(const Size3& size) { return {{0, 0, 0}, {size.x, size.y, size.z}}; }

/// The common part of two boxes; empty when they do not meet.
inline Box intersection(const Box& a, const Box& b) {
  Box r;
  for (int axis = 0; axis < 3; ++axis) {
    r.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
    r.hi[axis] = std::max(r.lo[axis], std::min(a.hi[axis], b.hi[axis]));
  }
  return r;
}

/// A box at another place.
inline Box moved(const Box& box, const Index3& by) {
  return {{box.lo.x + by.x, box.lo.y + by.y, box.lo.z + by.z},
          {box.hi.x + by.x, box.hi.y + by.y, box.hi.z + by.z}};
}

/// The smallest box around two; an empty one counts for nothing.
inline Box united(const Box& a, const Box& b) {
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  Box r;
  for (int axis = 0; axis < 3; ++axis) {
    r.lo[axis] = std::min(a.lo[axis], b.lo[axis]);
    r.hi[axis] = std::max(a.hi[axis], b.hi[axis]);
  }
  return r;
}

/// How many cells of a grid a box meets along each axis.
/// side  of a cell; the first one begins at 0
inline Size3 cells_met(const Box& box, const Size3& side) {
  Size3 met;
  for (int axis = 0; axis < 3; ++axis) {
    met[axis] = (box.hi[axis] - 1) / side[axis] - box.lo[axis] / side[axis] + 1;
  }
  return met;
}

/// Calls visit(place) for the cells of a grid that a box meets, x fastest, until it gives false.
/// side  of a cell; the first one begins at 0
template <class Visit>
void visit_cells(const Box& box, const Size3& side, Visit&& visit) {
  for (std::int64_t z = box.lo.z / side.z; z * side.z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y / side.y; y * side.y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x / side.x; x * side.x < box.hi.x; ++x) {
        if (!visit(Index3{x, y, z})) return;
      }
    }
  }
}

}  // namespace octavo
