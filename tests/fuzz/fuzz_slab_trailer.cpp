// Slab trailers of arbitrary bytes: one that is read is written as it was.
//
//     u8 choice | u8 bricks | u8 planes | trailer

#include "fuzz/fuzz_target.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/slab_trailer.h"

namespace {

using namespace octavo;

constexpr std::uint8_t kIsSealed = 1;

/// Gives the trailer the length and the checksum that it has.
void seal(Bytes& bytes) {
  if (bytes.size() < 8) return;
  const std::size_t at = bytes.size() - 8;
  store_little_endian(static_cast<std::uint32_t>(bytes.size()), bytes.data() + at);
  store_little_endian(crc32c(ByteSpan(bytes).first(at + 4)), bytes.data() + at + 4);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const bool is_sealed = (input.take<std::uint8_t>() & kIsSealed) != 0;
  const auto bricks = input.take<std::uint8_t>();
  const auto planes = input.take<std::uint8_t>();
  Bytes bytes = input.take_bytes(input.left());
  if (is_sealed) seal(bytes);
  fuzz::expect_error_or_success([&] {
    const SlabTrailer trailer = parse_slab_trailer(bytes, bricks, planes);
    fuzz::require(trailer.lengths.size() == bricks, "another number of bricks");
    fuzz::require(trailer.plane_digests.size() == planes, "another number of planes");
    if (is_sealed) fuzz::require(encode_slab_trailer(trailer) == bytes, "another trailer");
  });
  return 0;
}
