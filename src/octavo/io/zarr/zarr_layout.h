// What an array of zarr is: its axes, its chunks, and what these went through. Versions 2 and 3.
//
// Source  Zarr storage specification 2; Zarr core specification 3.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/io/source/stored_type.h"
#include "octavo/io/zarr/zarr_value.h"

namespace octavo {

/// Bytes to bytes.
enum class ZarrPacking : std::uint8_t { zstd, blosc, deflate, crc32c };

/// What values went through, one after the other.
struct ZarrCodecs {
  std::vector<std::size_t> order;      ///< axes as they are stored, the slowest first
  bool big_endian = false;
  std::vector<ZarrPacking> packings;
};

/// How chunks stand in a file together.
struct ZarrSharding {
  std::vector<std::int64_t> shape;   ///< of the file, in voxels
  std::vector<std::int64_t> chunks;  ///< of the file, along each axis
  bool is_index_at_start = false;
  bool is_index_big_endian = false;
  bool has_index_checksum = false;

  std::uint64_t chunk_count() const;
  std::uint64_t index_bytes() const;
};

/// How the file of a chunk, or of a shard, is called behind the name of its array.
struct ZarrKeys {
  bool has_prefix = true;  ///< "c"
  char separator = '/';

  std::string key_of(const std::vector<std::int64_t>& place) const;
};

/// An array. All vectors have a value for each axis, the slowest first.
struct ZarrLayout {
  std::vector<std::int64_t> shape;
  std::vector<std::int64_t> chunk;  ///< voxels that were packed together
  StoredType type;
  std::array<std::byte, 8> fill{};  ///< a value, in native byte order
  ZarrCodecs codecs;
  std::optional<ZarrSharding> sharding;  ///< nothing: each chunk is a file
  ZarrKeys keys;

  std::size_t dimensions() const { return shape.size(); }
  std::uint64_t chunk_bytes() const;
};

inline constexpr std::uint64_t kMostChunkBytes = std::uint64_t{1} << 30;

/// The array that zarr.json (3) or .zarray (2) describes.
/// Throws  Error{source_rejected} naming the file and what of it is not read
ZarrLayout read_zarr_layout(const ZarrValue& array);

}  // namespace octavo
