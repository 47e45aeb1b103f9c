#include <array>
#include <limits>
#include <random>
#include <span>

#include "fuzz/brick_input.h"
#include "fuzz/seeds/seed_folder.h"
#include "fuzz/seeds/seed_voxels.h"
#include "octavo/codec/brick_codec.h"

namespace octavo::fuzz {

namespace {

/// Sizes of a brick as side_of numbers them.
using Sides = std::array<std::uint8_t, 3>;

constexpr Sides cube(std::uint8_t side) { return {side, side, side}; }

constexpr std::uint8_t kCutSide = 6;  ///< 33 voxels: two parts

Size3 size_of(const Sides& sides) {
  return {side_of(sides[0]), side_of(sides[1]), side_of(sides[2])};
}

BrickShape shape_of(const Size3& size) {
  return brick_shape(Levels(size, choose_halvings(size, {1, 1, 1})), 0, {0, 0, 0});
}

/// The mirror image of fuzz::take_brick.
Bytes input_of(const BrickCodec& codec, const TrainingBrick& voxels, std::uint8_t choice,
               const Sides& sides, std::int64_t lowest) {
  const EncodedBrick brick = codec.encode(voxels.shape, voxels.view);
  const Bytes model = codec.serialized();
  Bytes out = {choice, sides[0], sides[1], sides[2]};
  put(out, static_cast<std::uint16_t>(model.size()));
  put_bytes(out, model);
  put(out, static_cast<std::uint32_t>(brick.range.min - lowest));
  put(out, static_cast<std::uint32_t>(brick.range.max - lowest));
  for (std::size_t i = 0; i < brick.segments.size(); ++i) {
    if (i + 1 < brick.segments.size())
      put(out, static_cast<std::uint16_t>(brick.segments[i].size()));
    put_bytes(out, brick.segments[i]);
  }
  return out;
}

struct BrickSeed {
  std::uint8_t type = 0;
  VolumeKind kind = VolumeKind::grey;
  Sides sides{};
  CodecSettings settings = {};
  Content content = Content::shape;
};

Bytes brick_input(const BrickSeed& seed) {
  const Size3 size = size_of(seed.sides);
  const VoxelType type = kTypes[seed.type];
  const Bytes voxels = make_voxels(size, type, seed.kind, seed.content);
  const TrainingBrick training{shape_of(size),
                               {voxels.data(), type, size, size.x, size.x * size.y}};
  const auto codec = train_model(seed.kind, type, std::span(&training, 1), seed.settings);
  const auto type_choice =
      static_cast<int>(seed.type) + seed.settings.detail_level * static_cast<int>(kTypes.size());
  const auto choice =
      static_cast<std::uint8_t>(type_choice | (seed.kind == VolumeKind::labels ? 0x80 : 0));
  return input_of(*codec, training, choice, seed.sides, value_range(type).min);
}

/// Floats of one of the codings that brick_input.h knows: noise, zeros, NaN and infinities.
Bytes exact_brick_input(std::uint8_t coding_number, std::uint8_t side) {
  const SampleCoding& coding = kFuzzedCodings[coding_number];
  const Size3 size = size_of(cube(side));
  std::mt19937 random(side);
  std::normal_distribution<double> noise(0, 20 * coding.scale);
  std::vector<float> voxels;
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    const std::uint32_t sort = random() % 16;
    const double value = sort < 4 ? 0 : coding.offset + noise(random);
    voxels.push_back(sort > 14   ? std::numeric_limits<float>::quiet_NaN()
                     : sort > 13 ? std::numeric_limits<float>::infinity()
                                 : static_cast<float>(value));
  }
  const TrainingBrick training{
      shape_of(size), {voxels.data(), VoxelType::float32, size, size.x, size.x * size.y}};
  const auto codec = train_exact_model({&training, 1}, {}, coding);
  return input_of(*codec, training, static_cast<std::uint8_t>(kExactChoice + coding_number),
                  cube(side), value_range(coding.type).min);
}

std::vector<BrickSeed> grey_seeds(std::uint8_t type) {
  std::vector<BrickSeed> seeds;
  const auto add = [&](const Sides& sides, const CodecSettings& settings, Content content) {
    seeds.push_back({type, VolumeKind::grey, sides, settings, content});
  };
  // Gaps, edges and steps between values
  for (const Content content : {Content::multiples, Content::speckles}) {
    for (const Preset preset : {Preset::small, Preset::fast}) add(cube(5), {preset, 0}, content);
  }
  // Prediction from means; rounded voxels; quantized details with corrections
  for (const CodecSettings& settings :
       {CodecSettings{Preset::fast, 0}, {Preset::small, 1}, {Preset::fast, 25}}) {
    add(cube(4), settings, Content::shape);
  }
  // Details left out
  for (const CodecSettings& settings : {CodecSettings{.detail_level = 1},
                                        {.preset = Preset::fast, .detail_level = 2}}) {
    add(cube(5), settings, Content::shape);
  }
  // Parts that decode alone: of both predictors, with edges, with corrections; cut along one axis
  for (const Content content : {Content::shape, Content::speckles}) {
    for (const Sides& sides : {cube(kCutSide), Sides{kCutSide, 2, 2}, Sides{2, kCutSide, 2},
                               Sides{2, 2, kCutSide}}) {
      for (const CodecSettings& settings :
           {CodecSettings{.preset = Preset::small, .access = Access::slices},
            {.preset = Preset::fast, .access = Access::boxes},
            {.preset = Preset::fast, .max_error = 25, .access = Access::boxes}}) {
        add(sides, settings, content);
      }
    }
  }
  return seeds;
}

void save_brick(SeedFolder& seeds, const BrickSeed& seed) {
  const Bytes input = brick_input(seed);
  seeds.save("brick", input);
  seeds.save("simd", input);
  if (seed.kind != VolumeKind::labels) return;
  Bytes of_labels = {0};
  put_bytes(of_labels, input);
  seeds.save("label_streams", of_labels);
}

}  // namespace

void save_bricks(SeedFolder& seeds) {
  for (const VolumeKind kind : {VolumeKind::grey, VolumeKind::labels}) {
    for (std::uint8_t type = 0; type < kTypes.size(); ++type) {
      for (const std::uint8_t side : std::to_array<std::uint8_t>({0, 2, 4, 5})) {
        save_brick(seeds, {type, kind, cube(side)});
      }
      if (kind == VolumeKind::labels) {
        save_brick(seeds, {type, kind, cube(4), {}, Content::speckles});
        continue;
      }
      for (const BrickSeed& seed : grey_seeds(type)) save_brick(seeds, seed);
    }
  }
  for (std::uint8_t coding = 0; coding < kFuzzedCodings.size(); ++coding) {
    for (const std::uint8_t side : std::to_array<std::uint8_t>({0, 2, 4, 5})) {
      const Bytes input = exact_brick_input(coding, side);
      seeds.save("brick", input);
      seeds.save("simd", input);
    }
  }
}

}  // namespace octavo::fuzz
