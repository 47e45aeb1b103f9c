#include "octavo/tasks/volume_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "octavo/core/error.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

constexpr const char* kAxisNames = "xyz";

[[noreturn]] void reject(const std::string& text) {
  throw Error(ErrorKind::invalid_argument, text);
}

/// The range of the eight corners of a world box, seen from the grid.
BoxMm index_range(const BoxMm& box, const Geometry& geometry) {
  BoxMm range{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const auto end = [&](std::size_t axis) {
      return (corner >> axis & 1) == 0 ? box.lo[axis] : box.hi[axis];
    };
    const Point3 index = geometry.to_index({end(0), end(1), end(2)});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      range.lo[axis] = std::min(range.lo[axis], index[axis]);
      range.hi[axis] = std::max(range.hi[axis], index[axis]);
    }
  }
  return range;
}

}  // namespace

Box box_within(const AskedBox& asked, const Size3& size) {
  Box box = box_of(size);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    box.lo[axis] = asked.lo[a].value_or(box.lo[axis]);
    box.hi[axis] = asked.hi[a].value_or(box.hi[axis]);
    if (box.lo[axis] >= 0 && box.lo[axis] < box.hi[axis] && box.hi[axis] <= size[axis]) continue;
    reject(fmt::format("box: {} = {}:{}; must be a part of 0:{} that is not empty",
                       kAxisNames[axis], box.lo[axis], box.hi[axis], size[axis]));
  }
  return box;
}

Box box_within_mm(const BoxMm& asked, const Geometry& geometry, const Size3& size) {
  constexpr double kRoundingSlack = 1e-6;
  const BoxMm range = index_range(asked, geometry);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const auto limit = static_cast<double>(size[axis]);
    box.lo[axis] = static_cast<std::int64_t>(
        std::clamp(std::ceil(range.lo[a] - kRoundingSlack), 0.0, limit));
    box.hi[axis] = static_cast<std::int64_t>(
        std::clamp(std::floor(range.hi[a] + kRoundingSlack) + 1, 0.0, limit));
  }
  if (!box.is_empty()) return box;
  const Point3 last = geometry.to_world({static_cast<double>(size.x - 1),
                                         static_cast<double>(size.y - 1),
                                         static_cast<double>(size.z - 1)});
  reject(fmt::format("the box from {} to {} mm holds no voxel; the volume runs from {} to {} mm",
                     point_text(asked.lo, ", "), point_text(asked.hi, ", "),
                     point_text(geometry.origin_mm, ", "), point_text(last, ", ")));
}

void require_level(const Levels& levels, int level) {
  if (level >= 0 && level < levels.count()) return;
  reject(fmt::format("level {}; the file has levels 0 to {}", level, levels.count() - 1));
}

}  // namespace octavo
