#include "octavo/builder/voxel_block.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "octavo/builder/crypto_hasher.h"
#include "octavo/builder/sha256_lanes.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/layer_order.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

// Of a voxel in the block, in voxels.
std::int64_t offset_of(const VoxelBlock& block, const Index3& at) {
  return ((at.z - block.first_plane) * block.size.y + at.y) * block.size.x + at.x;
}

}  // namespace

BrickView view_of(const VoxelBlock& block, const Box& box) {
  BrickView view;
  view.voxels = block.voxels + offset_of(block, box.lo) * bytes_per_voxel(block.type);
  view.type = block.type;
  view.size = box.size();
  view.row_stride = block.size.x;
  view.plane_stride = block.size.x * block.size.y;
  return view;
}

std::uint32_t content_hash_of(const VoxelBlock& block) {
  if (block.codes_crc) return *block.codes_crc;
  if (block.floats == nullptr) return block.crc;
  const auto bytes =
      static_cast<std::size_t>(block.size.voxel_count() * bytes_per_voxel(block.type));
  return crc32c({reinterpret_cast<const std::uint8_t*>(block.voxels), bytes});
}

BrickView float_view_of(const VoxelBlock& block, const Box& box) {
  BrickView view = view_of(block, box);
  view.voxels = block.floats + offset_of(block, box.lo);
  view.type = VoxelType::float32;
  return view;
}

void put_voxels(const VoxelBlock& block, const Box& box, const std::byte* voxels) {
  const std::int64_t width = bytes_per_voxel(block.type);
  const auto row_bytes = static_cast<std::size_t>(box.size().x * width);
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, voxels += row_bytes) {
      const std::int64_t offset = offset_of(block, {box.lo.x, y, z});
      std::memcpy(block.voxels + offset * width, voxels, row_bytes);
    }
  }
}

std::vector<Sha256Digest> plane_digests(const VoxelBlock& block, std::int64_t first,
                                        std::int64_t count,
                                        const std::optional<SampleCoding>& coding) {
  const auto voxel_count = static_cast<std::size_t>(block.size.x * block.size.y);
  const std::size_t plane_bytes =
      voxel_count * static_cast<std::size_t>(bytes_per_voxel(block.type));
  // Two planes side by side take less time; one of floats less memory.
  const std::size_t at_once = coding ? 1 : 2;
  std::vector<Sha256Digest> digests(static_cast<std::size_t>(count));
  ZeroStates zero_states;
  // A thread that waits here takes none of the bricks that wait for another plane.
  run_isolated([&] {
    const std::size_t turns = (digests.size() + at_once - 1) / at_once;
    parallel_for(std::size_t{0}, turns, [&](std::size_t turn) {
      const std::size_t begin = turn * at_once;
      const std::size_t planes = std::min(at_once, digests.size() - begin);
      const std::byte* const from =
          block.voxels + (static_cast<std::size_t>(first) + begin) * plane_bytes;
      std::vector<float> floats(coding ? voxel_count : 0);
      if (coding) decode_samples(*coding, from, floats);
      const std::span<const std::byte> bytes = coding
                                                   ? std::as_bytes(std::span<const float>(floats))
                                                   : std::span(from, planes * plane_bytes);
      Sha256Lanes lanes(planes, zero_states);
      lanes.add({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
      const std::vector<Sha256Digest> found = lanes.digests();
      std::copy(found.begin(), found.end(), digests.begin() + static_cast<std::ptrdiff_t>(begin));
    });
  });
  return digests;
}

Sha256Digest uniform_plane_digest(const VolumeDescription& volume, std::int64_t code) {
  constexpr std::int64_t kRunVoxels = std::int64_t{1} << 16;
  const auto hasher = make_crypto_hasher();
  with_voxel_type(volume.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    std::int64_t left = volume.size.x * volume.size.y;
    const std::vector<T> run(static_cast<std::size_t>(std::min(left, kRunVoxels)),
                             static_cast<T>(volume.voxel_of(code)));
    const ByteSpan bytes(reinterpret_cast<const std::uint8_t*>(run.data()), run.size() * sizeof(T));
    for (; left > 0; left -= kRunVoxels) {
      hasher->add(bytes.first(static_cast<std::size_t>(std::min(left, kRunVoxels)) * sizeof(T)));
    }
  });
  return hasher->digest();
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
