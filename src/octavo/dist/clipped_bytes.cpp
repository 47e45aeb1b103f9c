#include "octavo/dist/clipped_bytes.h"

#include <bit>
#include <cstdint>

#include "octavo/file/byte_codec.h"

namespace octavo {

Bytes clipped_bytes(const ClippedVoxels& clipped) {
  Bytes bytes;
  ByteWriter out(bytes);
  out.put_u64(static_cast<std::uint64_t>(clipped.count));
  out.put_u32(std::bit_cast<std::uint32_t>(clipped.farthest));
  out.put_u64(std::bit_cast<std::uint64_t>(clipped.limit));
  return bytes;
}

ClippedVoxels take_clipped(ByteSpan& bytes, const char* what) {
  ByteReader in(bytes, what);
  ClippedVoxels clipped;
  const std::uint64_t count = in.u64();
  constexpr std::uint64_t kMost = std::uint64_t{1} << 46;  // so that all parts may be added up
  if (count > kMost) in.fail("has a count that is none");
  clipped.count = static_cast<std::int64_t>(count);
  clipped.farthest = std::bit_cast<float>(in.u32());
  clipped.limit = std::bit_cast<double>(in.u64());
  bytes = bytes.last(in.left());
  return clipped;
}

}  // namespace octavo
