// The lines of voxel centers along one of the 26 directions, as the points of a picture.
//
// Seen along a direction d of {-1, 0, 1}^3 every voxel center lies on one line of centers, and the
// lines stand on a lattice: each has whole coordinates (u, v) that are linear in the voxel.
//
//     d                 u          v          a cube of side s covers
//     along one axis    y          z          s x s lines with s of its voxels each
//     across an edge    x - y      z          s (2s - 1) lines with s - |u| voxels
//     across a corner   x - z      y - z      a hexagon of 3s(s - 1) + 1 lines with
//                                             s - (max(u, v, 0) - min(u, v, 0)) voxels
//
// u and v are counted from the middle of the cube; axes that d runs down are mirrored first.
// So what a whole cube gives to a line is one product, without a look at its voxels, and a sum over
// cubes is the sum over voxels exactly.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/octree/o_code.h"

namespace octavo {

/// The lattice of the lines through a grid. u >= 0 and v >= 0 for all its voxels.
struct VoxelLines {
  Direction along;
  Size3 size;               ///< of the grid
  int axes = 1;             ///< components of `along` that are not 0: 1, 2 or 3
  std::int64_t width = 0;   ///< lines have u in 0 .. width - 1
  std::int64_t height = 0;  ///< and v in 0 .. height - 1
  std::array<int, 3> u_step{};  ///< u grows by so much with each coordinate
  std::array<int, 3> v_step{};
  std::int64_t u_start = 0;  ///< of voxel (0, 0, 0)
  std::int64_t v_start = 0;

  std::int64_t u_of(const Index3& voxel) const {
    return u_start + u_step[0] * voxel.x + u_step[1] * voxel.y + u_step[2] * voxel.z;
  }
  std::int64_t v_of(const Index3& voxel) const {
    return v_start + v_step[0] * voxel.x + v_step[1] * voxel.y + v_step[2] * voxel.z;
  }
};

/// The lattice for lines along `along` through a grid of `size`.
/// Throws Error{invalid_argument} on a direction without a component or with one beyond -1 .. 1.
VoxelLines voxel_lines(const Size3& size, const Direction& along);

/// The lines that a box meets, half-open.
struct LineRange {
  std::int64_t u_lo = 0;
  std::int64_t v_lo = 0;
  std::int64_t u_hi = 0;
  std::int64_t v_hi = 0;
};
LineRange lines_of(const VoxelLines& lines, const Box& box);

/// 1 for every line that meets a voxel of a box, else 0; [v][u]. By the voxels where they enter it.
std::vector<std::uint8_t> lines_through(const VoxelLines& lines, const Box& box);

/// The eight octants in an order in which none hides one before it from an observer who looks along
/// `along`: the farthest, its face neighbors, those of the nearest, the nearest. Source thesis 4.3
std::array<int, 8> back_to_front(const Direction& along);

/// Calls visit(u, v, count) for every line that meets a cube of side `side`, u and v counted from
/// the lowest of the cube; `count` of its voxels lie on the line.
/// axes  of the direction: 1, 2 or 3
template <class Visit>
void for_each_line(int axes, std::int64_t side, Visit&& visit) {
  const std::int64_t m = side - 1;
  if (axes == 1) {
    for (std::int64_t v = 0; v < side; ++v) {
      for (std::int64_t u = 0; u < side; ++u) visit(u, v, side);
    }
  } else if (axes == 2) {
    for (std::int64_t v = 0; v < side; ++v) {
      for (std::int64_t u = -m; u <= m; ++u) visit(u + m, v, side - std::abs(u));
    }
  } else {
    for (std::int64_t v = -m; v <= m; ++v) {
      const std::int64_t first = std::max(-m, v - m);
      const std::int64_t last = std::min(m, v + m);
      for (std::int64_t u = first; u <= last; ++u) {
        const std::int64_t zero = 0;
        visit(u + m, v + m, side - (std::max({u, v, zero}) - std::min({u, v, zero})));
      }
    }
  }
}

}  // namespace octavo
