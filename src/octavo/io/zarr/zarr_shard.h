// Chunks of zarr, compressed, and shards of them.
//
//     [chunk] [chunk] ...  index: offset and length of each, C order; those of a chunk that is left
//                          out, since all its voxels are 0, are 2^64 - 1.  CRC-32C of the index
//
// Source  Zarr core specification 3.0, sharding codec
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/voxel_type.h"
#include "octavo/io/zarr/zarr_text.h"

namespace octavo {

/// A chunk, compressed; by zstd with a checksum of the voxels.
/// voxels  little-endian
/// Throws  Error{out_of_memory} where there is none to compress; Error{internal}
std::vector<std::uint8_t> packed_chunk(std::span<const std::uint8_t> voxels, VoxelType type,
                                       ZarrCompression compression);

/// The bytes and their CRC-32C behind them.
std::vector<std::uint8_t> with_checksum(std::vector<std::uint8_t> bytes);

/// The file of a shard; empty where no chunk has bytes.
/// chunks  in C order, those left out empty
std::vector<std::uint8_t> shard_of(const std::vector<std::vector<std::uint8_t>>& chunks);

}  // namespace octavo
