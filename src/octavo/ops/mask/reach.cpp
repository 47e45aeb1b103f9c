#include "octavo/ops/mask/reach.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/core/size_tolerance.h"

namespace octavo {

namespace {

double square(double value) { return value * value; }

// The largest n <= most with (n * spacing)^2 <= room; -1 when there is none.
std::int64_t steps_within(double room, double spacing, std::int64_t most) {
  if (!(room >= 0)) return -1;
  const double quotient = std::floor(std::sqrt(room) / spacing);
  auto steps = static_cast<std::int64_t>(std::min(quotient, static_cast<double>(most)));
  while (steps < most && square(static_cast<double>(steps + 1) * spacing) <= room) ++steps;
  while (steps > 0 && square(static_cast<double>(steps) * spacing) > room) --steps;
  return steps;
}

}  // namespace

template <class Run>
Reach::Reach(const Index3& longest, std::uint64_t max_bytes, Run run) : longest_(longest) {
  const auto count = static_cast<std::size_t>((longest.y + 1) * (longest.z + 1));
  require_memory_within(count * sizeof(std::int32_t), max_bytes, "the table of a radius",
                        "raise the limit, or take a smaller radius");
  runs_.reserve(count);
  for (std::int64_t z = 0; z <= longest.z; ++z) {
    for (std::int64_t y = 0; y <= longest.y; ++y) {
      const std::int64_t along = run(y, z);
      runs_.push_back(static_cast<std::int32_t>(std::clamp<std::int64_t>(along, -1, longest.x)));
    }
  }
}

Reach Reach::within_mm(double radius_mm, const Point3& spacing_mm, const Size3& size,
                       std::uint64_t max_bytes) {
  if (!(radius_mm >= 0) || !std::isfinite(radius_mm)) {
    throw Error(ErrorKind::invalid_argument, "a radius must be 0 mm or more");
  }
  const double limit = square(upper_limit(radius_mm));
  Index3 longest;
  for (int axis = 0; axis < 3; ++axis) {
    longest[axis] =
        steps_within(limit, spacing_mm[static_cast<std::size_t>(axis)], size[axis] - 1);
  }
  return {longest, max_bytes, [&](std::int64_t y, std::int64_t z) {
            const double room = limit - square(static_cast<double>(y) * spacing_mm[1]) -
                                square(static_cast<double>(z) * spacing_mm[2]);
            return steps_within(room, spacing_mm[0], longest.x);
          }};
}

Reach Reach::in_steps(std::int64_t count, Connectivity connectivity, const Size3& size,
                      std::uint64_t max_bytes) {
  if (count < 0) throw Error(ErrorKind::invalid_argument, "a number of steps must be 0 or more");
  count = std::min(count, size.x + size.y + size.z);
  Index3 longest;
  for (int axis = 0; axis < 3; ++axis) longest[axis] = std::min(count, size[axis] - 1);
  return {longest, max_bytes, [&](std::int64_t y, std::int64_t z) {
            // A step goes along one axis, two or three at once.
            switch (connectivity) {
              case Connectivity::faces: return count - y - z;
              case Connectivity::edges: return std::min(count, 2 * count - y - z);
              case Connectivity::corners: break;
            }
            return count;
          }};
}

}  // namespace octavo
