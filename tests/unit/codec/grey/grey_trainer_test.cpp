// What models learn, within a max error as well, and models of later groups, which start from the
// first group's.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <string>

#include "octavo/codec/grey/grey_codec.h"
#include "octavo/codec/refine_model.h"

namespace octavo {
namespace {

/// 32 bricks: a sample of a larger group.
constexpr Size3 kSize = {512, 256, 16};
constexpr Size3 kBrick = {64, 64, 16};

/// Waves with noise of so many bits, all of them multiples of a step.
class Group {
 public:
  /// short_waves  how high shorter waves along x are, beside the usual ones
  /// repeats      whether all planes have the same noise, but for its last two bits
  /// balls        how far balls rise out of a plain that is there in place of the waves
  Group(std::uint32_t seed, int noise_bits, double step = 1, double short_waves = 0,
        bool repeats = false, double balls = 0) {
    std::mt19937 random(seed);
    for (std::int64_t z = 0; z < kSize.z; ++z) {
      std::mt19937 of_plane(seed);
      for (std::int64_t y = 0; y < kSize.y; ++y) {
        for (std::int64_t x = 0; x < kSize.x; ++x) {
          const double wave = std::sin(0.2 * static_cast<double>(x)) *
                                  std::cos(0.15 * static_cast<double>(y + 2 * z)) +
                              short_waves * std::sin(0.9 * static_cast<double>(x));
          const auto noise = repeats ? (of_plane() >> (32 - noise_bits)) + (random() >> 30)
                                     : random() >> (32 - noise_bits);
          voxels_.push_back(static_cast<std::int16_t>(
              step * std::floor((balls > 0 ? balls * is_in_ball(x, y, z) : 400 * wave) +
                                static_cast<double>(noise))));
        }
      }
    }
    const Levels levels(kSize, choose_halvings(kSize, {1, 1, 1}));
    for (std::int64_t y = 0; y < kSize.y / kBrick.y; ++y) {
      for (std::int64_t x = 0; x < kSize.x / kBrick.x; ++x) {
        const std::int64_t at = y * kBrick.y * kSize.x + x * kBrick.x;
        bricks_.push_back({brick_shape(levels, 0, {x, y, 0}),
                           {voxels_.data() + at, VoxelType::int16, kBrick, kSize.x,
                            kSize.x * kSize.y}});
      }
    }
  }
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;

  std::span<const TrainingBrick> bricks() const { return bricks_; }

 private:
  static bool is_in_ball(std::int64_t x, std::int64_t y, std::int64_t z) {
    const std::int64_t from_center[] = {x % 64 - 32, y % 64 - 32, 2 * z - 16};
    std::int64_t squares = 0;
    for (const std::int64_t d : from_center) squares += d * d;
    return squares < 28 * 28;
  }

  std::vector<std::int16_t> voxels_;
  std::vector<TrainingBrick> bricks_;
};

std::unique_ptr<BrickCodec> trained(std::span<const TrainingBrick> bricks,
                                    const CodecSettings& settings) {
  return train_grey_model(VoxelType::int16, bricks, settings);
}

std::unique_ptr<BrickCodec> refined(const BrickCodec& first, std::span<const TrainingBrick> bricks,
                                    const CodecSettings& settings) {
  return refine_model(first, VoxelType::int16, bricks, settings);
}

std::size_t size_of(const BrickCodec& codec, const Group& group) {
  std::size_t size = 0;
  for (const TrainingBrick& brick : group.bricks()) {
    for (const Bytes& segment : codec.encode(brick.shape, brick.view).segments) {
      size += segment.size();
    }
  }
  return size;
}

std::int64_t largest_error(const BrickCodec& codec, const TrainingBrick& brick) {
  const EncodedBrick encoded = codec.encode(brick.shape, brick.view);
  std::vector<std::int16_t> decoded(static_cast<std::size_t>(kBrick.voxel_count()));
  const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
  codec.decode(brick.shape, VoxelType::int16, encoded.range, segments, 0, decoded.data());
  std::int64_t largest = 0;
  std::size_t i = 0;
  for (std::int64_t z = 0; z < kBrick.z; ++z) {
    for (std::int64_t y = 0; y < kBrick.y; ++y) {
      const auto* const row = static_cast<const std::int16_t*>(brick.view.voxels) +
                              z * brick.view.plane_stride + y * brick.view.row_stride;
      for (std::int64_t x = 0; x < kBrick.x; ++x) {
        largest = std::max<std::int64_t>(largest, std::abs(decoded[i++] - row[x]));
      }
    }
  }
  return largest;
}

TEST(GreyTrainer, RoundingNeverHidesGapsAtACost) {
  const Group stretched(1, 2, 5);
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto lossless = trained(stretched.bricks(), {preset, 0});
    const auto within = trained(stretched.bricks(), {preset, 1});
    EXPECT_LE(size_of(*within, stretched), size_of(*lossless, stretched));
    EXPECT_LE(largest_error(*within, stretched.bricks().front()), 1);
  }
}

TEST(GreyTrainer, RoundingNeverHidesFewValuesAtACost) {
  const Group balls(1, 1, 61, 0, false, 3);
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto lossless = trained(balls.bricks(), {preset, 0});
    for (const std::int64_t max_error : {1, 3}) {
      const auto within = trained(balls.bricks(), {preset, max_error});
      EXPECT_LE(size_of(*within, balls), size_of(*lossless, balls)) << max_error;
    }
  }
}

/// Bytes of the group's bricks under a model of the fast preset with some of its weights left out,
/// relative to those under the model itself.
double size_without(const Group& group, void (*leave_out)(grey::Parameters&)) {
  using grey::GreyCodec;
  const auto model = trained(group.bricks(), {Preset::fast, 0});
  grey::Parameters p = dynamic_cast<const GreyCodec&>(*model).parameters();
  leave_out(p);
  return static_cast<double>(size_of(GreyCodec(p), group)) /
         static_cast<double>(size_of(*model, group));
}

TEST(FastModel, PredictsNoiseThatThePlaneBehindHasToo) {
  const auto leave_out = [](grey::Parameters& p) {
    for (auto& group : p.behind_weights) {
      for (auto& along : group) std::fill(std::begin(along), std::end(along), 0);
    }
  };
  EXPECT_GT(size_without(Group(4, 6, 1, 0, true), leave_out), 1.1);
}

TEST(FastModel, PredictsShortWavesFromMeansTwoAway) {
  const auto leave_out = [](grey::Parameters& p) {
    for (auto& group : p.far_shares) std::fill(std::begin(group), std::end(group), 0);
  };
  EXPECT_GT(size_without(Group(5, 2, 1, 0.5), leave_out), 1.02);
}

/// At an edge details are all or nothing: what is predicted between the two makes most of them
/// larger, and costs more than the edges themselves.
TEST(GreyTrainer, PredictsNothingWhereEdgesStandInNoise) {
  constexpr int kNoiseBits = 3;
  const Group balls(6, kNoiseBits, 1, 0, false, 1000);
  const auto noise_bytes = static_cast<double>(kSize.voxel_count() * kNoiseBits / 8);
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto model = trained(balls.bricks(), {preset, 0});
    EXPECT_LT(static_cast<double>(size_of(*model, balls)), 1.22 * noise_bytes);
  }
}

std::string name_of(const CodecSettings& settings) {
  return std::string(settings.preset == Preset::fast ? "fast" : "small") +
         (settings.max_error > 0 ? "_lossy" : "");
}

class RefinementOf : public ::testing::TestWithParam<CodecSettings> {
 protected:
  /// Training, with the order of axes that a first model brings along.
  std::unique_ptr<BrickCodec> trained_behind(const BrickCodec& first_of,
                                             std::span<const TrainingBrick> bricks) const {
    CodecSettings settings = GetParam();
    settings.axis_order = first_of.axis_order();
    return trained(bricks, settings);
  }

  /// Made once for all laws: to make them takes most of the time.
  static const Group& alike() {
    static const Group group(2, 4);
    return group;
  }
  static const Group& other() {
    static const Group group(3, 7);
    return group;
  }
  static const BrickCodec& first_model() {
    static const Group group(1, 4);
    static std::map<std::string, std::unique_ptr<BrickCodec>> models;
    auto& model = models[name_of(GetParam())];
    if (!model) model = trained(group.bricks(), GetParam());
    return *model;
  }
  /// The first model, refined for the group that is alike.
  static const BrickCodec& refined_model() {
    static std::map<std::string, std::unique_ptr<BrickCodec>> models;
    auto& model = models[name_of(GetParam())];
    if (!model) model = refined(first_model(), alike().bricks(), GetParam());
    return *model;
  }
};

TEST_P(RefinementOf, ComesToTheSameFromAParsedModel) {
  const auto parsed = parse_grey_model(VoxelType::int16, first_model().serialized());
  EXPECT_EQ(refined(*parsed, alike().bricks(), GetParam())->serialized(),
            refined_model().serialized());
}

/// Noise asks for no weights of its own: a model that has them fits its own bricks a little better.
TEST_P(RefinementOf, StartsFromTheFirstModelWhereContentIsAlike) {
  const auto second_model = trained_behind(first_model(), alike().bricks());
  EXPECT_NE(refined_model().serialized(), second_model->serialized());
  EXPECT_NE(refined_model().serialized(), first_model().serialized());
  EXPECT_LE(static_cast<double>(size_of(refined_model(), alike())),
            static_cast<double>(size_of(*second_model, alike())) * 1.003);
}

TEST_P(RefinementOf, IsTrainingWhereContentIsAnother) {
  EXPECT_EQ(refined(first_model(), other().bricks(), GetParam())->serialized(),
            trained_behind(first_model(), other().bricks())->serialized());
}

TEST_P(RefinementOf, IsTrainingBehindAGroupWithoutContent) {
  const auto empty = trained({}, GetParam());
  EXPECT_EQ(refined(*empty, alike().bricks(), GetParam())->serialized(),
            trained_behind(*empty, alike().bricks())->serialized());
}

TEST_P(RefinementOf, IsTrainingWhereBricksAreFew) {
  const auto few = alike().bricks().first(7);
  EXPECT_EQ(refined(first_model(), few, GetParam())->serialized(),
            trained_behind(first_model(), few)->serialized());
}

TEST_P(RefinementOf, KeepsWithinTheMaximumError) {
  for (const TrainingBrick& brick : alike().bricks().first(3)) {
    EXPECT_LE(largest_error(refined_model(), brick), GetParam().max_error);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryKind, RefinementOf,
                         ::testing::Values(CodecSettings{Preset::small, 0},
                                           CodecSettings{Preset::fast, 0},
                                           CodecSettings{Preset::small, 2}),
                         [](const auto& of) { return name_of(of.param); });

}  // namespace
}  // namespace octavo
