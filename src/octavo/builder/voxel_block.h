// A run of whole planes in memory, and the bricks in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/core/volume.h"

namespace octavo {

/// Bricks of a block whose planes are not in memory: a run of them in file order, or rows of a
/// layer, x fastest.
struct BrickBand {
  std::size_t first = 0;                       ///< how many of the block come before them
  std::vector<std::size_t> numbers;            ///< in file order among those of the block
  std::vector<Index3> bricks;
  std::vector<BrickView> views;                ///< of each brick
  std::vector<std::vector<std::byte>> voxels;  ///< what the views look at
  std::vector<BrickView> float_views;          ///< of VoxelBlock::floats, where there are any
  std::vector<std::vector<float>> floats;
  std::span<const Sha256Digest> digests;  ///< of all planes of the block; none where voxels change
};

/// Planes first_plane .. first_plane + size.z - 1 of the finest level of a tier, [z][y][x].
/// The block starts and ends where brick layers do, or where the volume ends.
struct VoxelBlock {
  std::byte* voxels = nullptr;
  VoxelType type = VoxelType::uint8;
  Size3 size;
  std::int64_t first_plane = 0;
  /// The float voxels that the integers stand for, [z][y][x], where these do not say all of them.
  const float* floats = nullptr;
  std::uint32_t crc = 0;  ///< CRC-32C of the floats if there are any, else of the voxels
  BrickBand* band = nullptr;  ///< the bricks that are there, where `voxels` is null
  std::optional<std::uint32_t> codes_crc = {};  ///< then, where floats stand beside codes
};

/// The voxels of `box` (in the tier's samples), which lies in the block.
BrickView view_of(const VoxelBlock& block, const Box& box);
/// The same of block.floats.
BrickView float_view_of(const VoxelBlock& block, const Box& box);

/// Puts voxels, dense [z][y][x] of `box`, into the block in place of those that stand there.
void put_voxels(const VoxelBlock& block, const Box& box, const std::byte* voxels);

/// CRC-32C of the block's voxels as bricks hold them: of the first group, what the build id takes
/// for the voxels.
std::uint32_t content_hash_of(const VoxelBlock& block);

/// The digests of `count` planes of the block, counted from its own first one; of the floats that
/// `coding` makes of them, if given. Uses the threads of the calling task arena.
std::vector<Sha256Digest> plane_digests(const VoxelBlock& block, std::int64_t first,
                                        std::int64_t count,
                                        const std::optional<SampleCoding>& coding);

/// The digest of a plane of the volume whose voxels are all what `code` stands for.
Sha256Digest uniform_plane_digest(const VolumeDescription& volume, std::int64_t code);

/// True when all voxels of the brick have one value. Stops at the first that differs.
bool is_uniform(const BrickView& brick);

/// The bricks of a block in file order: layer by layer, o-code order inside a layer.
std::vector<Index3> bricks_of(const Levels& levels, int tier, const VoxelBlock& block);

}  // namespace octavo
