// Segments of arbitrary bytes through the grey and the label decoder, for every type and many
// shapes. Of a brick that decodes as a whole the parts decode, too, and to the same voxels; in
// builds with checksums parts are rejected whose bytes are not those in their list.

#include <algorithm>

#include "fuzz/brick_input.h"
#include "octavo/core/crc32c.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace octavo;
  fuzz::Input input(data, size);
  fuzz::expect_error_or_success([&] {
    const fuzz::BrickInput brick = fuzz::take_brick(input);
    const auto codec = fuzz::codec_of(brick);
    fuzz::expect_error_or_success([&] {
      codec->decode_parent(brick.shape, brick.voxel_type(), brick.range, brick.spans());
    });
    const auto parts = std::make_unique<std::uint8_t[]>(brick.level_bytes(0));
    const bool has_checksums = !checksum_matches(0, 1);
    bool has_parts = false;
    bool has_thrown = true;
    fuzz::expect_error_or_success([&] {
      has_parts = fuzz::decode_parts(*codec, brick, parts.get());
      has_thrown = false;
    });
    for (int level = brick.shape.level_count - 1; level >= 0; --level) {
      const auto out = std::make_unique<std::uint8_t[]>(brick.level_bytes(level));
      codec->decode(brick.shape, brick.voxel_type(), brick.range, brick.spans(), level, out.get());
      const bool is_same = std::equal(out.get(), out.get() + brick.level_bytes(level), parts.get());
      if (level > 0) continue;
      fuzz::require(!has_thrown || has_checksums, "a brick that decodes without its parts");
      fuzz::require(!has_parts || has_thrown || is_same, "parts of other voxels");
    }
  });
  return 0;
}
