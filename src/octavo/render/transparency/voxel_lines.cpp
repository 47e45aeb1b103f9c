#include "octavo/render/transparency/voxel_lines.h"

#include <cstdlib>
#include <numeric>

#include "octavo/core/error.h"

namespace octavo {

namespace {

std::array<int, 3> components(const Direction& d) { return {d.x, d.y, d.z}; }

std::size_t at(int axis) { return static_cast<std::size_t>(axis); }

// The minimum and the maximum of a coordinate over a box, from its first voxel on.
void widen(const std::array<int, 3>& step, const Size3& size, std::int64_t& lo, std::int64_t& hi) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t most = step[at(axis)] * (size[axis] - 1);
    lo += std::min<std::int64_t>(0, most);
    hi += std::max<std::int64_t>(0, most);
  }
}

}  // namespace

VoxelLines voxel_lines(const Size3& size, const Direction& along) {
  const std::array<int, 3> d = components(along);
  VoxelLines lines;
  lines.along = along;
  lines.size = size;
  lines.axes = static_cast<int>(std::count_if(d.begin(), d.end(), [](int c) { return c != 0; }));
  const bool is_unit = std::all_of(d.begin(), d.end(), [](int c) { return std::abs(c) <= 1; });
  if (lines.axes == 0 || !is_unit) {
    throw Error(ErrorKind::invalid_argument,
                "lines of voxels run along steps of -1, 0 or 1, not all 0");
  }
  // Two coordinates that a step along `along` leaves alone.
  if (lines.axes == 3) {
    lines.u_step = {d[0], 0, -d[2]};
    lines.v_step = {0, d[1], -d[2]};
  } else if (lines.axes == 2) {
    const int free = d[0] == 0 ? 0 : d[1] == 0 ? 1 : 2;
    const int first = free == 0 ? 1 : 0;
    const int second = free == 2 ? 1 : 2;
    lines.u_step[at(first)] = d[at(first)];
    lines.u_step[at(second)] = -d[at(second)];
    lines.v_step[at(free)] = 1;
  } else {
    const int axis = d[0] != 0 ? 0 : d[1] != 0 ? 1 : 2;
    lines.u_step[axis == 0 ? 1 : 0] = 1;
    lines.v_step[axis == 2 ? 1 : 2] = 1;
  }
  std::int64_t u_lo = 0, u_hi = 0, v_lo = 0, v_hi = 0;
  widen(lines.u_step, size, u_lo, u_hi);
  widen(lines.v_step, size, v_lo, v_hi);
  lines.u_start = -u_lo;
  lines.v_start = -v_lo;
  lines.width = u_hi - u_lo + 1;
  lines.height = v_hi - v_lo + 1;
  return lines;
}

LineRange lines_of(const VoxelLines& lines, const Box& box) {
  LineRange range;
  range.u_lo = range.u_hi = lines.u_of(box.lo);
  range.v_lo = range.v_hi = lines.v_of(box.lo);
  widen(lines.u_step, box.size(), range.u_lo, range.u_hi);
  widen(lines.v_step, box.size(), range.v_lo, range.v_hi);
  ++range.u_hi;
  ++range.v_hi;
  return range;
}

std::vector<std::uint8_t> lines_through(const VoxelLines& lines, const Box& box) {
  std::vector<std::uint8_t> met(static_cast<std::size_t>(lines.width * lines.height));
  const int along[] = {lines.along.x, lines.along.y, lines.along.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (along[axis] == 0) continue;
    Box face = box;
    if (along[axis] > 0) face.hi[axis] = std::min(face.hi[axis], face.lo[axis] + 1);
    else face.lo[axis] = std::max(face.lo[axis], face.hi[axis] - 1);
    Index3 at;
    for (at.z = face.lo.z; at.z < face.hi.z; ++at.z) {
      for (at.y = face.lo.y; at.y < face.hi.y; ++at.y) {
        for (at.x = face.lo.x; at.x < face.hi.x; ++at.x) {
          met[static_cast<std::size_t>(lines.v_of(at) * lines.width + lines.u_of(at))] = 1;
        }
      }
    }
  }
  return met;
}

std::array<int, 8> back_to_front(const Direction& along) {
  std::array<int, 8> order{};
  std::iota(order.begin(), order.end(), 0);
  const auto depth = [&](int octant) {
    return along.z * (octant >> 2 & 1) + along.x * (octant >> 1 & 1) + along.y * (octant & 1);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return depth(a) > depth(b); });
  return order;
}

}  // namespace octavo
