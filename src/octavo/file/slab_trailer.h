// What stands behind the finest pieces of each layer of bricks: enough to find them again, and
// to know that the slab is whole, when a build was interrupted before the index was written.
//
// The trailer ends in its own length, so that slabs can be visited from their end backwards:
//
//   magic "8slb" | u64 build id | varint slab | varint model | varint length of each piece
//   | SHA-256 of each plane | u32 CRC of the slab before the trailer | u32 length of the trailer
//   | u32 CRC of the trailer so far
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/hasher.h"

namespace octavo {

/// What errors call it.
inline constexpr char kSlabTrailer[] = "slab trailer";

struct SlabTrailer {
  std::uint64_t build_id = 0;
  std::uint64_t slab = 0;
  std::uint64_t model = 0;
  std::vector<std::uint64_t> lengths;  ///< of the pieces, in layer order; 0 when uniform
  std::vector<Sha256Digest> plane_digests;  ///< of the voxels of its planes, by z
  std::uint32_t slab_crc = 0;  ///< CRC-32C of the model, if one stands here, and the pieces
};

Bytes encode_slab_trailer(const SlabTrailer& trailer);

/// The trailer of a slab of `brick_count` bricks and `plane_count` planes. Throws Error{corrupt}.
SlabTrailer parse_slab_trailer(ByteSpan bytes, std::int64_t brick_count, std::int64_t plane_count);

}  // namespace octavo
