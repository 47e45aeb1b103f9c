// Voxels as numbers, for comparisons that do not care for the type.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "octavo/core/voxel_type.h"

namespace octavo::testing {

/// The voxels in `bytes`, one number each.
inline std::vector<double> as_numbers(const std::vector<std::byte>& bytes, VoxelType type) {
  std::vector<double> numbers;
  with_voxel_type(type, [&](auto id) {
    using T = typename decltype(id)::type;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
      T voxel;
      std::memcpy(&voxel, bytes.data() + at, sizeof voxel);
      numbers.push_back(static_cast<double>(voxel));
    }
  });
  return numbers;
}

}  // namespace octavo::testing
