#include "octavo/io/zarr/zarr_chunk.h"

#include <blosc.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"
#include "octavo/io/source/byte_order.h"

namespace octavo {

namespace {

using ChunkBytes = std::vector<std::uint8_t>;

constexpr std::size_t kChecksumBytes = 4;

[[noreturn]] void reject_chunk(const std::string& why) {
  throw Error(ErrorKind::source_rejected, why);
}

void require_length(std::size_t found, std::size_t expected) {
  if (found == expected) return;
  reject_chunk("a chunk has " + std::to_string(found) + " bytes, " + std::to_string(expected) +
               " expected");
}

ChunkBytes zstd_unpacked(const ChunkBytes& packed, std::size_t bytes) {
  ChunkBytes chunk(bytes);
  const std::size_t found =
      ZSTD_decompress(chunk.data(), chunk.size(), packed.data(), packed.size());
  if (ZSTD_isError(found) != 0) {
    reject_chunk(std::string("a chunk is damaged (zstd: ") + ZSTD_getErrorName(found) + ")");
  }
  require_length(found, bytes);
  return chunk;
}

ChunkBytes blosc_unpacked(const ChunkBytes& packed, std::size_t bytes) {
  std::size_t found = 0;
  if (blosc_cbuffer_validate(packed.data(), packed.size(), &found) != 0) {
    reject_chunk("a chunk is damaged (blosc: it fits no header)");
  }
  require_length(found, bytes);
  ChunkBytes chunk(bytes);
  const int done = blosc_decompress_ctx(packed.data(), chunk.data(), chunk.size(), 1);
  if (done < 0) reject_chunk("a chunk is damaged, or of a kind of blosc that is not read");
  require_length(static_cast<std::size_t>(done), bytes);
  return chunk;
}

/// zlib or gzip, as its head says.
ChunkBytes inflated(const ChunkBytes& packed, std::size_t bytes) {
  constexpr int kAutoWindow = 15 + 32;
  z_stream stream{};
  if (inflateInit2(&stream, kAutoWindow) != Z_OK) {
    throw Error(ErrorKind::out_of_memory, "no memory for decompression");
  }
  // One byte more, so that what is too long is seen.
  ChunkBytes chunk(bytes + 1);
  stream.next_in = const_cast<Bytef*>(packed.data());
  stream.next_out = chunk.data();
  constexpr std::size_t kMostAtOnce = std::numeric_limits<uInt>::max();
  stream.avail_in = static_cast<uInt>(std::min(packed.size(), kMostAtOnce));
  stream.avail_out = static_cast<uInt>(chunk.size());
  const int state = inflate(&stream, Z_FINISH);
  const std::size_t found = stream.total_out;
  inflateEnd(&stream);
  if (state != Z_STREAM_END && found <= bytes) reject_chunk("a chunk is damaged (gzip)");
  require_length(found, bytes);
  chunk.resize(bytes);
  return chunk;
}

ChunkBytes proven(ChunkBytes packed) {
  if (packed.size() < kChecksumBytes) reject_chunk("a chunk is shorter than its checksum");
  const std::size_t length = packed.size() - kChecksumBytes;
  const auto stored = load_little_endian<std::uint32_t>(packed.data() + length);
  packed.resize(length);
  if (!checksum_matches(crc32c(packed), stored)) reject_chunk("the checksum of a chunk is wrong");
  return packed;
}

ChunkBytes undone(ZarrPacking packing, ChunkBytes packed, std::size_t bytes) {
  switch (packing) {
    case ZarrPacking::zstd: return zstd_unpacked(packed, bytes);
    case ZarrPacking::blosc: return blosc_unpacked(packed, bytes);
    case ZarrPacking::deflate: return inflated(packed, bytes);
    case ZarrPacking::crc32c: break;
  }
  return proven(std::move(packed));
}

/// Whether what stands in front of a packing has a known length: nothing but checksums does.
bool is_length_known(std::span<const ZarrPacking> before) {
  return std::ranges::all_of(before, [](ZarrPacking p) { return p == ZarrPacking::crc32c; });
}

}  // namespace

std::vector<std::uint8_t> unpacked_chunk(std::vector<std::uint8_t> packed,
                                         const ZarrLayout& layout) {
  const auto bytes = static_cast<std::size_t>(layout.chunk_bytes());
  const std::vector<ZarrPacking>& packings = layout.codecs.packings;
  for (std::size_t i = packings.size(); i-- > 0;) {
    const std::span<const ZarrPacking> before = std::span(packings).first(i);
    if (packings[i] != ZarrPacking::crc32c && !is_length_known(before)) {
      reject_chunk("chunks that were compressed twice are not read");
    }
    packed = undone(packings[i], std::move(packed), bytes + kChecksumBytes * before.size());
  }
  require_length(packed.size(), bytes);
  if (needs_swap(layout.codecs.big_endian)) {
    swap_values(std::as_writable_bytes(std::span(packed)), bytes_per_value(layout.type));
  }
  return packed;
}

}  // namespace octavo
