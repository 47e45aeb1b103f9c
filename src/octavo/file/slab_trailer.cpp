#include "octavo/file/slab_trailer.h"

#include <algorithm>
#include <array>

#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

constexpr std::array<std::uint8_t, 4> kSlabMagic = {'8', 's', 'l', 'b'};
constexpr std::size_t kEndBytes = 12;

}  // namespace

Bytes encode_slab_trailer(const SlabTrailer& trailer) {
  Bytes bytes(kSlabMagic.begin(), kSlabMagic.end());
  ByteWriter out(bytes);
  out.put_u64(trailer.build_id);
  out.put_varint(trailer.slab);
  out.put_varint(trailer.model);
  for (const std::uint64_t length : trailer.lengths) out.put_varint(length);
  for (const Sha256Digest& digest : trailer.plane_digests) {
    bytes.insert(bytes.end(), digest.begin(), digest.end());
  }
  out.put_u32(trailer.slab_crc);
  out.put_u32(static_cast<std::uint32_t>(bytes.size() + 8));
  out.put_u32(crc32c(bytes));
  return bytes;
}

SlabTrailer parse_slab_trailer(ByteSpan bytes, std::int64_t brick_count, std::int64_t plane_count) {
  ByteReader in(bytes, kSlabTrailer);
  const auto magic = in.take(kSlabMagic.size());
  if (!std::equal(magic.begin(), magic.end(), kSlabMagic.begin())) in.fail("starts otherwise");
  SlabTrailer trailer;
  trailer.build_id = in.u64();
  trailer.slab = in.varint();
  trailer.model = in.varint();
  if (static_cast<std::uint64_t>(brick_count) > in.left()) in.fail("ends early");
  for (std::int64_t i = 0; i < brick_count; ++i) trailer.lengths.push_back(in.varint());
  if (in.left() / sizeof(Sha256Digest) < static_cast<std::uint64_t>(plane_count)) {
    in.fail("ends early");
  }
  trailer.plane_digests.resize(static_cast<std::size_t>(plane_count));
  for (Sha256Digest& digest : trailer.plane_digests) {
    const ByteSpan stored = in.take(digest.size());
    std::copy(stored.begin(), stored.end(), digest.begin());
  }
  if (in.left() != kEndBytes) in.fail("is not as long as its contents");
  trailer.slab_crc = in.u32();
  if (in.u32() != bytes.size()) in.fail("states another length");
  if (!checksum_matches(crc32c(bytes.first(bytes.size() - 4)), in.u32())) {
    in.fail("checksum does not match");
  }
  return trailer;
}

}  // namespace octavo
