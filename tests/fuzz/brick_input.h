// A brick for the decoders, made of arbitrary bytes: of any type and many shapes, grey or labels.
#pragma once

#include <algorithm>
#include <array>

#include "fuzz/fuzz_target.h"
#include "octavo/codec/brick_codec.h"

namespace octavo::fuzz {

struct BrickInput {
  VolumeKind kind = VolumeKind::grey;
  VoxelType type = VoxelType::uint8;
  Bytes model;
  BrickShape shape;
  ValueRange range;
  std::vector<std::vector<std::uint8_t>> segments;

  std::optional<SampleCoding> coding;  ///< of float32 voxels
  int detail_level = 0;                ///< as CodecSettings::detail_level

  /// Of the voxels that the codec gives.
  VoxelType voxel_type() const { return coding ? VoxelType::float32 : type; }
  std::vector<ByteSpan> spans() const { return {segments.begin(), segments.end()}; }
  std::size_t level_bytes(int level) const {
    return static_cast<std::size_t>(shape.size[static_cast<std::size_t>(level)].voxel_count() *
                                    bytes_per_voxel(voxel_type()));
  }
};

inline constexpr std::array<VoxelType, 6> kTypes = {VoxelType::int8,  VoxelType::uint8,
                                                    VoxelType::int16, VoxelType::uint16,
                                                    VoxelType::int32, VoxelType::uint32};

inline constexpr std::uint8_t kExactChoice = 48;
inline constexpr std::array<SampleCoding, 3> kFuzzedCodings = {
    {{VoxelType::int32, 0.25, 0, true},
     {VoxelType::int32, 0.1, 1000.3, true},
     {VoxelType::int32, 0x1p-148, 0, true}}};

/// Sizes that matter: full bricks, odd edges, single rows.
inline std::int64_t side_of(std::uint8_t byte) {
  constexpr std::array<std::int64_t, 8> kSides = {1, 2, 3, 5, 8, 17, 33, 64};
  return kSides[byte % kSides.size()];
}

inline ValueRange range_of(Input& input, VoxelType type) {
  const ValueRange all = value_range(type);
  const auto width = static_cast<std::uint64_t>(all.max - all.min) + 1;
  const auto a = static_cast<std::int64_t>(input.take<std::uint32_t>() % width) + all.min;
  const auto b = static_cast<std::int64_t>(input.take<std::uint32_t>() % width) + all.min;
  return {std::min(a, b), std::max(a, b)};
}

/// Throws Error for a shape that no file can have.
inline BrickInput take_brick(Input& input) {
  BrickInput brick;
  const auto choice = input.take<std::uint8_t>();
  // Types 48 and up: exact floats.
  const bool is_exact = (choice & 0x80) == 0 && (choice & 0x3f) >= kExactChoice;
  brick.type = is_exact ? VoxelType::int32 : kTypes[(choice & 0x3f) % kTypes.size()];
  if (is_exact) brick.coding = kFuzzedCodings[(choice & 0x3f) % kFuzzedCodings.size()];
  // Types 6 and up: with details left out.
  constexpr int kTypeCount = static_cast<int>(kTypes.size());
  if (!is_exact) brick.detail_level = (choice & 0x3f) / kTypeCount % kTierLevels;
  brick.kind = choice & 0x80 ? VolumeKind::labels : VolumeKind::grey;
  Size3 extent;
  for (int axis = 0; axis < 3; ++axis) extent[axis] = side_of(input.take<std::uint8_t>());
  const double thickness = choice & 0x40 ? 4 : 1;
  brick.model = input.take_bytes(input.take<std::uint16_t>());
  const Levels levels(extent, choose_halvings(extent, {1, 1, thickness}));
  brick.shape = brick_shape(levels, 0, {0, 0, 0});
  brick.range = range_of(input, brick.type);
  for (int i = 0; i < brick.shape.level_count; ++i) {
    const bool is_last = i + 1 == brick.shape.level_count;
    brick.segments.push_back(
        input.take_bytes(is_last ? input.left() : input.take<std::uint16_t>()));
  }
  return brick;
}

/// The codec of a brick's model; the last one is kept, because building its tables takes longer
/// than decoding. Throws Error{corrupt}.
inline std::shared_ptr<const BrickCodec> codec_of(const BrickInput& brick) {
  static VolumeKind kept_kind;
  static VoxelType kept_type;
  static std::optional<SampleCoding> kept_coding;
  static int kept_level;
  static Bytes kept_model;
  static std::shared_ptr<const BrickCodec> kept;
  if (!kept || brick.kind != kept_kind || brick.type != kept_type ||
      brick.coding != kept_coding || brick.detail_level != kept_level ||
      brick.model != kept_model) {
    kept.reset();
    kept = parse_model(brick.kind, brick.type, brick.coding, brick.model, brick.detail_level);
    kept_coding = brick.coding;
    kept_level = brick.detail_level;
    kept_kind = brick.kind;
    kept_type = brick.type;
    kept_model = brick.model;
  }
  return kept;
}

/// Decodes the parts of a brick, each alone, into `out`, an array of its level 0; false where it
/// has none. Throws Error{corrupt}.
inline bool decode_parts(const BrickCodec& codec, const BrickInput& brick, std::uint8_t* out) {
  const std::vector<ByteSpan> segments = brick.spans();
  const auto opened = codec.open_parts(brick.shape, brick.type, brick.range, segments);
  if (!opened) return false;
  const Size3& size = brick.shape.size[0];
  for (std::size_t i = 0; i < opened->parts().size(); ++i) {
    const BrickParts::Part& part = opened->parts()[i];
    const ByteSpan finest = segments[0];
    if (part.offset > finest.size() || part.length > finest.size() - part.offset) {
      throw Error(ErrorKind::corrupt, "a part beyond its segment");
    }
    const std::int64_t first = (part.box.lo.z * size.y + part.box.lo.y) * size.x + part.box.lo.x;
    opened->decode(i, finest.subspan(part.offset, part.length),
                   {out + first * bytes_per_voxel(brick.type), size.x, size.x * size.y});
  }
  return true;
}

}  // namespace octavo::fuzz
