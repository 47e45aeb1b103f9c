// Voxels as numbers, for comparisons that do not care for the type.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "octavo/core/voxel_type.h"

namespace octavo::testing {

/// The voxels in `bytes`, one number each. Requires a type of numbers that holds them.
template <class Number = double, class ByteVector>
std::vector<Number> as_numbers(const ByteVector& bytes, VoxelType type) {
  static_assert(sizeof(*bytes.data()) == 1);
  std::vector<Number> numbers;
  with_voxel_type(type, [&](auto id) {
    using T = typename decltype(id)::type;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
      T voxel;
      std::memcpy(&voxel, bytes.data() + at, sizeof voxel);
      numbers.push_back(static_cast<Number>(voxel));
    }
  });
  return numbers;
}

}  // namespace octavo::testing
