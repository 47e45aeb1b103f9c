// Parts of a volume as people ask for them: levels, boxes in voxels or in mm.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/levels.h"
#include "octavo/tasks/geometry_words.h"

namespace octavo {

/// A half-open box; a side left out is the end of the volume. Axes x, y, z.
struct AskedBox {
  std::array<std::optional<std::int64_t>, 3> lo;
  std::array<std::optional<std::int64_t>, 3> hi;
};

/// Throws Error{invalid_argument} when the box is empty or not inside `size`, naming the axis.
Box box_within(const AskedBox& asked, const Size3& size);

/// The samples whose centers lie in a box of world space, clipped to the volume.
/// Throws Error{invalid_argument} when there are none.
Box box_within_mm(const BoxMm& asked, const Geometry& geometry, const Size3& size);

/// Throws Error{invalid_argument} unless 0 <= level < levels.count().
void require_level(const Levels& levels, int level);

}  // namespace octavo
