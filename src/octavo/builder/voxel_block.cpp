#include "octavo/builder/voxel_block.h"

#include <algorithm>
#include <cstring>

#include "octavo/file/layer_order.h"

namespace octavo {

BrickView view_of(const VoxelBlock& block, const Box& box) {
  const std::int64_t offset =
      ((box.lo.z - block.first_plane) * block.size.y + box.lo.y) * block.size.x + box.lo.x;
  BrickView view;
  view.voxels = block.voxels + offset * bytes_per_voxel(block.type);
  view.type = block.type;
  view.size = box.size();
  view.row_stride = block.size.x;
  view.plane_stride = block.size.x * block.size.y;
  return view;
}

BrickView float_view_of(const VoxelBlock& block, const Box& box) {
  VoxelBlock floats = block;
  floats.voxels = reinterpret_cast<const std::byte*>(block.floats);
  floats.type = VoxelType::float32;
  return view_of(floats, box);
}

bool is_uniform(const BrickView& brick) {
  const auto* const voxels = static_cast<const std::byte*>(brick.voxels);
  const std::int64_t width = bytes_per_voxel(brick.type);
  const auto row_bytes = static_cast<std::size_t>(brick.size.x * width);
  for (std::int64_t z = 0; z < brick.size.z; ++z) {
    for (std::int64_t y = 0; y < brick.size.y; ++y) {
      const std::byte* const row = voxels + (z * brick.plane_stride + y * brick.row_stride) * width;
      // A row equals itself one voxel on, and starts like the first one.
      if (std::memcmp(row, voxels, static_cast<std::size_t>(width)) != 0) return false;
      if (std::memcmp(row, row + width, row_bytes - static_cast<std::size_t>(width)) != 0)
        return false;
    }
  }
  return true;
}

std::vector<Index3> bricks_of(const Levels& levels, int tier, const VoxelBlock& block) {
  const Size3 grid = levels.brick_grid(tier);
  const std::int64_t layer_planes = levels.brick_side(tier).z;
  const std::int64_t end = block.first_plane + block.size.z;
  const std::vector<Index3> layer = layer_order(grid);
  std::vector<Index3> bricks;
  for (std::int64_t z = block.first_plane / layer_planes; z * layer_planes < end; ++z) {
    for (const Index3& brick : layer) bricks.push_back({brick.x, brick.y, z});
  }
  return bricks;
}

}  // namespace octavo
