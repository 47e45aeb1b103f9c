// The integer voxels of a brick, one after the other.
#pragma once

#include <cstdint>
#include <type_traits>

#include "octavo/codec/brick_codec.h"

namespace octavo {

/// Calls f(row) for the rows of a brick in the order z, y; `row` points to the first of size.x
/// voxels. Does nothing for float voxels.
template <class F>
void for_each_row(const BrickView& brick, F&& f) {
  with_voxel_type(brick.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    if constexpr (std::is_integral_v<T>) {
      for (std::int64_t z = 0; z < brick.size.z; ++z) {
        for (std::int64_t y = 0; y < brick.size.y; ++y) {
          f(static_cast<const T*>(brick.voxels) + z * brick.plane_stride + y * brick.row_stride);
        }
      }
    }
  });
}

/// Calls f(voxel) for the voxels of a brick in the order z, y, x.
template <class F>
void for_each_voxel(const BrickView& brick, F&& f) {
  for_each_row(brick, [&](const auto* row) {
    for (std::int64_t x = 0; x < brick.size.x; ++x) f(std::int64_t{row[x]});
  });
}

}  // namespace octavo
