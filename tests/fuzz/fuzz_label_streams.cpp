// Label bricks of arbitrary bytes as words and as voxels, and the streams they are made of.
//
//     u8 stream, then:
//     0 brick          as brick_input.h takes it
//     1 stored labels  u8 type | i32, i32 range | u16 voxels | bytes
//     2 model          u8 type | bytes

#include <algorithm>
#include <optional>

#include "fuzz/brick_input.h"
#include "octavo/codec/label/label_stored.h"
#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/codec/label_bricks.h"
#include "support/voxel_numbers.h"

namespace {

using namespace octavo;
using fuzz::require;
using octavo::testing::as_numbers;

/// What `decode` gives; nothing where it throws.
template <class F>
auto unless_damaged(F&& decode) -> std::optional<decltype(decode())> {
  try {
    return decode();
  } catch (const Error&) {
    return std::nullopt;
  }
}

void check_brick(fuzz::Input& input) {
  const fuzz::BrickInput brick = fuzz::take_brick(input);
  if (brick.kind != VolumeKind::labels) return;
  const auto codec = fuzz::codec_of(brick);
  const LabelBrickCodec& labels = as_label_codec(*codec);
  const auto voxels = unless_damaged([&] {
    Bytes out(brick.level_bytes(0));
    codec->decode(brick.shape, brick.type, brick.range, brick.spans(), 0, out.data());
    return out;
  });
  const auto words = unless_damaged([&] {
    LabelWords out;
    labels.decode_words(brick.shape, brick.range, brick.spans(), out);
    return out;
  });
  require(voxels.has_value() == words.has_value(), "voxels without words or words without voxels");
  if (!words) return;
  LabelWords of_voxels;
  words_of_voxels(brick.shape.size[0], as_numbers<std::int64_t>(*voxels, brick.type), of_voxels);
  require(*words == of_voxels, "words of other labels");

  const EncodedBrick encoded = labels.encode_words(brick.shape, *words);
  const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
  Bytes again(voxels->size());
  codec->decode(brick.shape, brick.type, encoded.range, segments, 0, again.data());
  require(again == *voxels, "other labels when they are written again");
}

void check_stored(fuzz::Input& input) {
  const VoxelType type = fuzz::kTypes[input.take<std::uint8_t>() % fuzz::kTypes.size()];
  const ValueRange range = fuzz::range_of(input, type);
  const std::int64_t count = 1 + input.take<std::uint16_t>() % 4096;
  const auto labels = decode_stored_labels(input.take_bytes(input.left()), range, count);
  require(static_cast<std::int64_t>(labels.size()) == count, "another number of labels");
  for (const std::int64_t label : labels) {
    require(label >= range.min && label <= range.max, "a label outside the range");
  }
}

void check_model(fuzz::Input& input) {
  const VoxelType type = fuzz::kTypes[input.take<std::uint8_t>() % fuzz::kTypes.size()];
  const LabelModel model = parse_label_weights(type, input.take_bytes(input.left()));
  const Bytes bytes = serialize(model, type);
  require(serialize(parse_label_weights(type, bytes), type) == bytes, "another model");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr void (*kStreams[])(fuzz::Input&) = {check_brick, check_stored, check_model};
  fuzz::Input input(data, size);
  const auto stream = input.take<std::uint8_t>() % std::size(kStreams);
  fuzz::expect_error_or_success([&] { kStreams[stream](input); });
  return 0;
}
