// Segments of arbitrary bytes through the grey and the label decoder, for every type and many
// shapes.

#include <array>

#include "fuzz/fuzz_target.h"
#include "octavo/codec/brick_codec.h"

namespace {

using namespace octavo;

constexpr std::array<VoxelType, 6> kTypes = {VoxelType::int8,  VoxelType::uint8,
                                             VoxelType::int16, VoxelType::uint16,
                                             VoxelType::int32, VoxelType::uint32};

/// Sizes that matter: full bricks, odd edges, single rows.
std::int64_t side_of(std::uint8_t byte) {
  constexpr std::array<std::int64_t, 8> kSides = {1, 2, 3, 5, 8, 17, 33, 64};
  return kSides[byte % kSides.size()];
}

ValueRange range_of(fuzz::Input& input, VoxelType type) {
  const ValueRange all = value_range(type);
  const auto width = static_cast<std::uint64_t>(all.max - all.min) + 1;
  const auto a = static_cast<std::int64_t>(input.take<std::uint32_t>() % width) + all.min;
  const auto b = static_cast<std::int64_t>(input.take<std::uint32_t>() % width) + all.min;
  return {std::min(a, b), std::max(a, b)};
}

/// The codec of a model; the last one is kept, because building its tables takes longer than
/// decoding.
std::shared_ptr<const BrickCodec> codec_of(VolumeKind kind, VoxelType type, const Bytes& model) {
  static VolumeKind kept_kind;
  static VoxelType kept_type;
  static Bytes kept_model;
  static std::shared_ptr<const BrickCodec> kept;
  if (!kept || kind != kept_kind || type != kept_type || model != kept_model) {
    kept.reset();
    kept = parse_model(kind, type, model);
    kept_kind = kind;
    kept_type = type;
    kept_model = model;
  }
  return kept;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const auto choice = input.take<std::uint8_t>();
  const VoxelType type = kTypes[choice % kTypes.size()];
  const VolumeKind kind = choice & 0x80 ? VolumeKind::labels : VolumeKind::grey;
  const Size3 extent{side_of(input.take<std::uint8_t>()), side_of(input.take<std::uint8_t>()),
                     side_of(input.take<std::uint8_t>())};
  const double thickness = choice & 0x40 ? 4 : 1;
  const auto model_bytes = input.take_bytes(input.take<std::uint16_t>());
  fuzz::expect_error_or_success([&] {
    const Levels levels(extent, choose_halvings(extent, {1, 1, thickness}));
    const BrickShape shape = brick_shape(levels, 0, {0, 0, 0});
    const ValueRange range = range_of(input, type);
    const auto codec = codec_of(kind, type, model_bytes);
    std::vector<std::vector<std::uint8_t>> segments;
    for (int i = 0; i < shape.level_count; ++i) {
      const bool is_last = i + 1 == shape.level_count;
      segments.push_back(input.take_bytes(is_last ? input.left() : input.take<std::uint16_t>()));
    }
    const std::vector<ByteSpan> spans(segments.begin(), segments.end());
    for (int level = shape.level_count - 1; level >= 0; --level) {
      const auto voxels =
          static_cast<std::size_t>(shape.size[static_cast<std::size_t>(level)].voxel_count());
      const auto out = std::make_unique<std::uint8_t[]>(
          voxels * static_cast<std::size_t>(bytes_per_voxel(type)));
      codec->decode(shape, type, range, spans, level, out.get());
    }
  });
  return 0;
}
