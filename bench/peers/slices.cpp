#include "bench/peers/peer.h"
#include "octavo/core/error.h"

namespace octavo::bench {

std::uint64_t Encoded::byte_count() const {
  std::uint64_t sum = extra_bytes;
  for (const Bytes& piece : pieces) sum += piece.size();
  return sum;
}

void require(bool ok, const char* what) {
  if (!ok) throw Error(ErrorKind::internal, std::string("peer failed: ") + what);
}

bool SlicePeer::supports(const RawVolume& volume) const {
  return is_integer(volume.type) && sample_bits(volume) <= 16;
}

Encoded SlicePeer::encode(const RawVolume& volume) {
  Encoded encoded;
  Slice slice{static_cast<std::uint32_t>(volume.size.x), static_cast<std::uint32_t>(volume.size.y),
              sample_bits(volume), {}};
  for (std::int64_t z = 0; z < volume.size.z; ++z) {
    slice.samples = plane_samples(volume, z);
    encoded.pieces.push_back(encode_slice(slice));
  }
  return encoded;
}

void SlicePeer::decode(const Encoded& encoded, RawVolume& volume) {
  Slice slice{static_cast<std::uint32_t>(volume.size.x), static_cast<std::uint32_t>(volume.size.y),
              sample_bits(volume), {}};
  slice.samples.resize(static_cast<std::size_t>(volume.size.x * volume.size.y));
  for (std::int64_t z = 0; z < volume.size.z; ++z) {
    decode_slice(encoded.pieces[static_cast<std::size_t>(z)], slice);
    put_plane_samples(volume, z, slice.samples);
  }
}

}  // namespace octavo::bench
