// Masks as arrays of one byte per voxel: what the trees are held against.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "octavo/ops/mask/mask_build.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo::testing {

inline constexpr Connectivity kConnectivities[] = {Connectivity::faces, Connectivity::edges,
                                                   Connectivity::corners};

struct DenseMask {
  Size3 size;
  std::vector<std::uint8_t> voxels;  ///< [z][y][x], 0 or 1

  std::uint8_t& at(const Index3& p) {
    return voxels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
  }
  std::uint8_t at(const Index3& p) const { return const_cast<DenseMask*>(this)->at(p); }
  bool operator==(const DenseMask&) const = default;
};

template <class F>
void for_each_voxel(const Size3& size, F f) {
  for (std::int64_t z = 0; z < size.z; ++z)
    for (std::int64_t y = 0; y < size.y; ++y)
      for (std::int64_t x = 0; x < size.x; ++x) f(Index3{x, y, z});
}

inline BrickView view_of(const DenseMask& mask) {
  return {mask.voxels.data(), VoxelType::uint8, mask.size, mask.size.x, mask.size.x * mask.size.y};
}

inline MaskTree tree_of(const DenseMask& mask) { return make_mask(view_of(mask), {1, 1}); }

inline DenseMask dense_of(const MaskTree& tree) {
  DenseMask mask{tree.size(),
                 std::vector<std::uint8_t>(static_cast<std::size_t>(tree.size().voxel_count()))};
  for_each_voxel(mask.size, [&](const Index3& p) { mask.at(p) = tree.contains(p) ? 1 : 0; });
  return mask;
}

/// Boxes put in and taken out at random, and single voxels: full and empty cubes of many sizes.
inline DenseMask random_mask(const Size3& size, std::mt19937& random) {
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  const auto below = [&](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  for (int boxes = 0; boxes < 6; ++boxes) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = below(3) == 0 ? 0 : below(size[axis]);
      box.hi[axis] = box.lo[axis] + 1 + below(size[axis] - box.lo[axis]);
    }
    const auto value = static_cast<std::uint8_t>(below(3) != 0);
    for_each_voxel(box.size(), [&](const Index3& p) {
      mask.at({box.lo.x + p.x, box.lo.y + p.y, box.lo.z + p.z}) = value;
    });
  }
  for (std::int64_t flips = below(40); flips > 0; --flips) {
    mask.at({below(size.x), below(size.y), below(size.z)}) ^= 1;
  }
  return mask;
}

inline const std::vector<Size3>& odd_sizes() {
  static const std::vector<Size3> sizes = {{1, 1, 1},    {4, 4, 4},     {5, 3, 7},   {64, 64, 64},
                                           {65, 64, 63}, {130, 67, 21}, {17, 1, 90}, {3, 280, 2},
                                           {70, 70, 70}};
  return sizes;
}

}  // namespace octavo::testing
