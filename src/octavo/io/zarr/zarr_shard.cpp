#include "octavo/io/zarr/zarr_shard.h"

#include <blosc.h>
#include <zstd.h>

#include <algorithm>
#include <memory>
#include <string>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

constexpr int kZarrLevel = 5;
constexpr std::uint64_t kLeftOut = ~std::uint64_t{0};

std::vector<std::uint8_t> zstd_packed(std::span<const std::uint8_t> voxels) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> state(ZSTD_createCCtx(),
                                                                   &ZSTD_freeCCtx);
  if (!state) throw Error(ErrorKind::out_of_memory, "no memory for compression");
  ZSTD_CCtx_setParameter(state.get(), ZSTD_c_compressionLevel, kZarrLevel);
  ZSTD_CCtx_setParameter(state.get(), ZSTD_c_checksumFlag, 1);
  std::vector<std::uint8_t> packed(ZSTD_compressBound(voxels.size()));
  const std::size_t length = ZSTD_compress2(state.get(), packed.data(), packed.size(),
                                            voxels.data(), voxels.size());
  if (ZSTD_isError(length) != 0) {
    throw Error(ErrorKind::internal, std::string("zstd: ") + ZSTD_getErrorName(length));
  }
  packed.resize(length);
  return packed;
}

std::vector<std::uint8_t> blosc_packed(std::span<const std::uint8_t> voxels, VoxelType type) {
  std::vector<std::uint8_t> packed(voxels.size() + BLOSC_MAX_OVERHEAD);
  const int length = blosc_compress_ctx(
      kZarrLevel, BLOSC_SHUFFLE, static_cast<std::size_t>(bytes_per_voxel(type)), voxels.size(),
      voxels.data(), packed.data(), packed.size(), BLOSC_ZSTD_COMPNAME, 0, 1);
  if (length <= 0) throw Error(ErrorKind::internal, "blosc does not compress a chunk");
  packed.resize(static_cast<std::size_t>(length));
  return packed;
}

}  // namespace

std::vector<std::uint8_t> packed_chunk(std::span<const std::uint8_t> voxels, VoxelType type,
                                       ZarrCompression compression) {
  switch (compression) {
    case ZarrCompression::zstd: return zstd_packed(voxels);
    case ZarrCompression::blosc: return blosc_packed(voxels, type);
    case ZarrCompression::none: break;
  }
  return {voxels.begin(), voxels.end()};
}

std::vector<std::uint8_t> with_checksum(std::vector<std::uint8_t> bytes) {
  const std::uint32_t checksum = crc32c(bytes);
  ByteWriter(bytes).put_u32(checksum);
  return bytes;
}

std::vector<std::uint8_t> shard_of(const std::vector<std::vector<std::uint8_t>>& chunks) {
  std::size_t length = 0;
  for (const auto& chunk : chunks) length += chunk.size();
  std::vector<std::uint8_t> shard;
  if (length == 0) return shard;
  shard.reserve(length + 16 * chunks.size() + 4);
  for (const auto& chunk : chunks) shard.insert(shard.end(), chunk.begin(), chunk.end());
  ByteWriter writer(shard);
  std::uint64_t at = 0;
  for (const auto& chunk : chunks) {
    writer.put_u64(chunk.empty() ? kLeftOut : at);
    writer.put_u64(chunk.empty() ? kLeftOut : chunk.size());
    at += chunk.size();
  }
  const std::span<const std::uint8_t> index(shard.data() + length, shard.size() - length);
  writer.put_u32(crc32c(index));
  return shard;
}

}  // namespace octavo
