// The voxels that seeds are made of.
#pragma once

#include <cstdint>
#include <cstring>
#include <random>

#include "octavo/core/box.h"
#include "octavo/core/bytes.h"
#include "octavo/core/volume.h"

namespace octavo::fuzz {

enum class Content {
  shape,      ///< a soft shape with some noise; half of it uniform; 32-bit types: a wide range
  multiples,  ///< the same, all values a step apart
  speckles    ///< few voxels on a ground of one value
};

inline std::int32_t value_at(Content content, std::int64_t width, bool is_inside,
                             std::uint32_t random) {
  const auto noise = static_cast<std::int32_t>(random % 9);
  const std::int32_t value = !is_inside ? 3 : 40 + noise;
  if (content == Content::speckles) {
    return random % 50 != 0 ? 3 : width == 4 ? static_cast<std::int32_t>(random / 8) : 9 + noise;
  }
  if (content == Content::multiples) return 3 * value;
  return width == 4 ? value * 40000 + noise % 3 : value;
}

/// Two labels; of speckles many.
inline std::int32_t label_at(Content content, bool is_inside, std::uint32_t random) {
  if (content == Content::speckles) return static_cast<std::int32_t>(random % 100);
  return is_inside ? 5 : 3;
}

/// Voxels of a content, dense [z][y][x].
inline Bytes make_voxels(const Size3& size, VoxelType type, VolumeKind kind, Content content) {
  std::mt19937 generator(static_cast<std::uint32_t>(size.x * 7 + size.y));
  const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
  const std::int64_t width = bytes_per_voxel(type);
  Bytes bytes(static_cast<std::size_t>(size.voxel_count() * width));
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x, at += static_cast<std::size_t>(width)) {
        const bool is_inside = x + y > size.y / 2;
        const std::int32_t stored = kind == VolumeKind::labels
                                        ? label_at(content, is_inside, random())
                                        : value_at(content, width, is_inside, random());
        std::memcpy(bytes.data() + at, &stored, static_cast<std::size_t>(width));
      }
    }
  }
  return bytes;
}

}  // namespace octavo::fuzz
