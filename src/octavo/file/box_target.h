// Where the voxels of a box go: a dense array [z][y][x], or a part of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "octavo/core/box.h"

namespace octavo {

struct BoxTarget {
  std::uint8_t* bytes;  ///< of the first voxel of the box; aligned or not
  std::size_t voxel_bytes;
  std::int64_t row_stride;  ///< in voxels, as the other one
  std::int64_t plane_stride;

  /// The voxels from one on, counted from the first of the box.
  std::uint8_t* row(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const std::int64_t at = z * plane_stride + y * row_stride + x;
    return bytes + static_cast<std::size_t>(at) * voxel_bytes;
  }

  /// The array of a box that begins at `lo`, inside the one that begins at `own_lo`.
  BoxTarget from(const Index3& lo, const Index3& own_lo) const {
    return {row(lo.x - own_lo.x, lo.y - own_lo.y, lo.z - own_lo.z), voxel_bytes, row_stride,
            plane_stride};
  }
};

/// Copies what `box` and the samples of `held`, a dense array, share into the array of `box`.
inline void copy_shared(const void* samples, const Box& held, const Box& box,
                        const BoxTarget& out) {
  const auto* const bytes = static_cast<const std::uint8_t*>(samples);
  const Box part = intersection(box, held);
  const Size3 size = held.size();
  const std::size_t row_bytes = static_cast<std::size_t>(part.size().x) * out.voxel_bytes;
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y) {
      const std::int64_t at = ((z - held.lo.z) * size.y + (y - held.lo.y)) * size.x +
                              (part.lo.x - held.lo.x);
      std::memcpy(out.row(part.lo.x - box.lo.x, y - box.lo.y, z - box.lo.z),
                  bytes + static_cast<std::size_t>(at) * out.voxel_bytes, row_bytes);
    }
  }
}

}  // namespace octavo
