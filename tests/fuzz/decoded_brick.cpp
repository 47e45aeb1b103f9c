// Compiled with the macro octavo naming the build's namespace.
#include "fuzz/decoded_brick.h"

#include "fuzz/brick_input.h"

namespace octavo::fuzz {

std::vector<DecodedLevel> decode_brick(const std::uint8_t* data, std::size_t size) {
  std::vector<DecodedLevel> levels;
  try {
    Input input(data, size);
    const BrickInput brick = take_brick(input);
    const auto codec = codec_of(brick);
    const auto keep = [&](int level, auto&& decode) {
      DecodedLevel& decoded = levels.emplace_back();
      // A block of exactly its size, so that a sanitizer sees every overrun.
      const auto out = std::make_unique<std::uint8_t[]>(brick.level_bytes(level));
      try {
        decode(out.get());
        decoded.voxels.assign(out.get(), out.get() + brick.level_bytes(level));
      } catch (const Error& error) {
        decoded.error = error.what();
      }
    };
    for (int level = brick.shape.level_count - 1; level >= 0; --level) {
      keep(level, [&](std::uint8_t* out) {
        codec->decode(brick.shape, brick.voxel_type(), brick.range, brick.spans(), level, out);
      });
    }
    keep(0, [&](std::uint8_t* out) { decode_parts(*codec, brick, out); });
  } catch (const Error& error) {
    levels.push_back({error.what(), {}});
  }
  return levels;
}

}  // namespace octavo::fuzz
