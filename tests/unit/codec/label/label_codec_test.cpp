#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include "octavo/codec/label/label_model.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/core/error.h"
#include "support/coded_brick.h"
#include "support/label_brick.h"

namespace octavo {
namespace {

using testing::balls;
using testing::decoded;
using testing::LabelBrick;
using testing::noise;

/// The labels of a level and how many voxels lie below each.
template <class T>
struct VotedLevel {
  std::vector<T> labels;
  std::vector<std::int64_t> voxel_counts;

  explicit VotedLevel(std::vector<T> voxels)
      : labels(std::move(voxels)), voxel_counts(labels.size(), 1) {}
};

/// The most frequent label of every octant, by counting in a map.
template <class T>
VotedLevel<T> voted(const VotedLevel<T>& fine, const Size3& size, HalvingMask mask) {
  const Size3 coarse = halved(size, mask);
  std::vector<std::map<T, std::int64_t>> counts(static_cast<std::size_t>(coarse.voxel_count()));
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::int64_t parent =
            ((z >> (mask >> 2 & 1)) * coarse.y + (y >> (mask >> 1 & 1))) * coarse.x +
            (x >> (mask & 1));
        const auto at = static_cast<std::size_t>((z * size.y + y) * size.x + x);
        counts[static_cast<std::size_t>(parent)][fine.labels[at]] += fine.voxel_counts[at];
      }
    }
  }
  VotedLevel<T> result({});
  for (const auto& count : counts) {
    const auto most =
        std::max_element(count.begin(), count.end(), [](const auto& a, const auto& b) {
          return a.second < b.second;  // of equal counts the first, which is the smallest
        });
    result.labels.push_back(most->first);
    result.voxel_counts.push_back(0);
    for (const auto& [label, voxels] : count) result.voxel_counts.back() += voxels;
  }
  return result;
}

template <class T>
void expect_round_trip(const BrickCodec& codec, const LabelBrick<T>& sample) {
  const EncodedBrick brick = codec.encode(sample.shape, sample.view());
  VotedLevel<T> expected(sample.voxels);
  for (int level = 0; level < sample.shape.level_count; ++level) {
    const auto i = static_cast<std::size_t>(level);
    ASSERT_EQ(decoded(codec, sample, brick, level), expected.labels) << "level " << level;
    expected = voted(expected, sample.shape.size[i], sample.shape.halving[i]);
  }
  ASSERT_EQ(expected.labels.size(), 1u);
  EXPECT_EQ(brick.parent, static_cast<std::int64_t>(expected.labels[0]));
  EXPECT_EQ(testing::decoded_parent(codec, sample.shape, voxel_type_of<T>(), brick), brick.parent);
}

template <class T>
class LabelCodecOfType : public ::testing::Test {};
TYPED_TEST_SUITE(LabelCodecOfType, testing::LabelTypes);

TYPED_TEST(LabelCodecOfType, EveryLevelIsTheVoteAndLevelZeroTheVoxels) {
  using T = TypeParam;
  const T low = std::numeric_limits<T>::min();
  const T high = std::numeric_limits<T>::max();
  for (const Size3& size : {Size3{64, 64, 64}, Size3{37, 64, 5}, Size3{13, 29, 31}}) {
    const auto sample = balls<T>(size, {3, low, T(5), high, T(7), T(0)});
    const TrainingBrick bricks[] = {sample.training()};
    expect_round_trip(*train_label_model(voxel_type_of<T>(), bricks), sample);
    expect_round_trip(*train_label_model(voxel_type_of<T>(), {}), sample);
  }
}

TYPED_TEST(LabelCodecOfType, RandomVoxelsComeBackWithAndWithoutTraining) {
  using T = TypeParam;
  const auto sample = noise<T>({21, 12, 17}, 1);
  const TrainingBrick bricks[] = {sample.training()};
  expect_round_trip(*train_label_model(voxel_type_of<T>(), bricks), sample);
  expect_round_trip(*train_label_model(voxel_type_of<T>(), {}), sample);
}

TEST(LabelCodec, OddAndFlatShapesComeBack) {
  const auto codec = train_label_model(VoxelType::uint8, {});
  for (const Size3& size : {Size3{1, 1, 1}, Size3{1, 1, 2}, Size3{1, 3, 1}, Size3{64, 1, 1},
                            Size3{2, 2, 64}, Size3{5, 7, 11}, Size3{63, 1, 33}}) {
    expect_round_trip(*codec, balls<std::uint8_t>(size, {1, 2, 3}));
    LabelBrick<std::uint8_t> bits = noise<std::uint8_t>(size, 2);
    for (std::uint8_t& voxel : bits.voxels) voxel &= 1;
    expect_round_trip(*codec, bits);
  }
}

TEST(LabelCodec, ALastVoxelAloneHasOneVote) {
  LabelBrick<std::uint8_t> sample({3, 1, 1});
  sample.voxels = {2, 2, 1};
  const auto codec = train_label_model(VoxelType::uint8, {});
  EXPECT_EQ(codec->encode(sample.shape, sample.view()).parent, 2);
}

TEST(LabelCodec, ThickSlicesHalveOnlyInPlane) {
  const auto sample = balls<std::uint8_t>({40, 48, 16}, {1, 2, 3, 4}, {1, 1, 4});
  ASSERT_NE(sample.shape.halving[0], kHalveAll);
  expect_round_trip(*train_label_model(VoxelType::uint8, {}), sample);
}

TEST(LabelCodec, UniformBrickHasNoBytes) {
  const auto codec = train_label_model(VoxelType::int16, {});
  auto sample = balls<std::int16_t>({16, 16, 16}, {-7});
  const EncodedBrick brick = codec->encode(sample.shape, sample.view());
  EXPECT_EQ(brick.range, (ValueRange{-7, -7}));
  EXPECT_EQ(brick.parent, -7);
  for (const Bytes& segment : brick.segments) EXPECT_TRUE(segment.empty());
  EXPECT_EQ(decoded(*codec, sample, brick, 0), sample.voxels);
}

TEST(LabelCodec, ParsedModelWritesTheSameBytes) {
  const auto sample = balls<std::int16_t>({64, 60, 50}, {0, 9, -300, 4, 21});
  const TrainingBrick bricks[] = {sample.training()};
  const auto trained = train_label_model(VoxelType::int16, bricks);
  const auto parsed = parse_label_model(VoxelType::int16, trained->serialized());
  EXPECT_EQ(parsed->serialized(), trained->serialized());
  EXPECT_EQ(parsed->encode(sample.shape, sample.view()).segments,
            trained->encode(sample.shape, sample.view()).segments);
}

TEST(LabelCodec, FinerSegmentsAreNotLookedAt) {
  const auto sample = balls<std::uint8_t>({32, 32, 32}, {1, 2, 3});
  const auto codec = train_label_model(VoxelType::uint8, {});
  EncodedBrick brick = codec->encode(sample.shape, sample.view());
  const auto expected = decoded(*codec, sample, brick, 2);
  brick.segments[0] = {1, 2, 3};
  brick.segments[1].clear();
  EXPECT_EQ(decoded(*codec, sample, brick, 2), expected);
}

TEST(LabelCodec, LabelsUnknownToTheModelComeBack) {
  const auto known = balls<std::uint16_t>({32, 32, 32}, {10, 20, 30});
  const TrainingBrick bricks[] = {known.training()};
  const auto codec = train_label_model(VoxelType::uint16, bricks);
  expect_round_trip(*codec, balls<std::uint16_t>({32, 32, 32}, {10, 15, 65535, 20}));
}

TEST(LabelCodec, FloatVoxelsAreRejected) {
  EXPECT_THROW(train_label_model(VoxelType::float32, {}), Error);
  EXPECT_THROW(parse_label_model(VoxelType::float32, {}), Error);
}

TEST(LabelCodec, WhatDoesNotFitTheModelIsRejected) {
  const auto sample = balls<std::uint8_t>({8, 8, 8}, {1, 2, 3});
  const auto codec = train_label_model(VoxelType::uint8, {});
  const EncodedBrick good = codec->encode(sample.shape, sample.view());
  const auto other = balls<std::int16_t>({8, 8, 8}, {1, 2, 3});
  EXPECT_THROW(codec->encode(other.shape, other.view()), Error);
  BrickView smaller = sample.view();
  smaller.size.x = 7;
  EXPECT_THROW(codec->encode(sample.shape, smaller), Error);
  EXPECT_THROW(train_model(VolumeKind::labels, VoxelType::uint8, {}, {Preset::small, 1}), Error);

  std::vector<std::uint8_t> out(512);
  const auto kind_of = [&](VoxelType type, const ValueRange& range, std::size_t segments,
                           int level) {
    std::vector<ByteSpan> given = testing::spans(good);
    given.resize(segments);
    try {
      codec->decode(sample.shape, type, range, given, level, out.data());
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::internal;
  };
  const std::size_t count = good.segments.size();
  EXPECT_EQ(kind_of(VoxelType::uint8, good.range, count, 0), ErrorKind::internal);
  EXPECT_EQ(kind_of(VoxelType::int8, good.range, count, 0), ErrorKind::invalid_argument);
  EXPECT_EQ(kind_of(VoxelType::uint8, good.range, count - 1, 0), ErrorKind::invalid_argument);
  EXPECT_EQ(kind_of(VoxelType::uint8, good.range, count, -1), ErrorKind::invalid_argument);
  EXPECT_EQ(kind_of(VoxelType::uint8, good.range, count, static_cast<int>(count)),
            ErrorKind::invalid_argument);
  for (const ValueRange& range : {ValueRange{3, 1}, ValueRange{-1, 3}, ValueRange{1, 256}}) {
    EXPECT_EQ(kind_of(VoxelType::uint8, range, count, 0), ErrorKind::corrupt);
  }
}

TEST(LabelCodec, ShapesThatLeadNowhereAreRejected) {
  const auto sample = balls<std::uint8_t>({8, 8, 8}, {1, 2, 3});
  const auto codec = train_label_model(VoxelType::uint8, {});
  const std::vector<std::uint8_t> voxels(65 * 64, 1);
  const std::function<void(BrickShape&)> changes[] = {
      [](BrickShape& s) { s.level_count = 0; },
      [](BrickShape& s) { s.level_count = kTierLevels + 1; },
      [](BrickShape& s) { s.level_count = 2; },
      [](BrickShape& s) { s.size[0] = {0, 8, 8}; },
      [](BrickShape& s) { s.size[0] = {65, 8, 8}; },
      [](BrickShape& s) { s.size[1].y = 3; },
      [](BrickShape& s) { s.halving[0] = 8; },
      [](BrickShape& s) { s.halving[1] = 3; },
  };
  for (const auto& change : changes) {
    BrickShape shape = sample.shape;
    change(shape);
    const Size3& size = shape.size[0];
    EXPECT_THROW(codec->encode(shape, {voxels.data(), VoxelType::uint8, size, size.x,
                                       size.x * size.y}),
                 Error);
    std::vector<std::uint8_t> out(65 * 64);
    const std::vector<ByteSpan> segments(static_cast<std::size_t>(shape.level_count));
    EXPECT_THROW(codec->decode(shape, VoxelType::uint8, {1, 3}, segments, 0, out.data()), Error);
  }
}

/// Random segments: rejected, or labels of the range. Many more labels than a coded brick may have
/// come up in some of them.
TEST(LabelCodec, ArbitraryBytesAreRejectedOrLabelsOfTheRange) {
  std::mt19937 random(3);
  const LabelBrick<std::uint32_t> sample({64, 64, 64});
  const auto codec = train_label_model(VoxelType::uint32, {});
  int rejected = 0;
  for (int round = 0; round < 24; ++round) {
    EncodedBrick brick;
    brick.range = {5, round % 2 == 0 ? 4'000'000'000 : 9};
    brick.segments.resize(static_cast<std::size_t>(sample.shape.level_count));
    for (Bytes& segment : brick.segments) {
      segment.resize(round < 20 ? 1 + random() % 3000 : std::size_t{1} << 18);
      for (auto& byte : segment) byte = static_cast<std::uint8_t>(random());
    }
    try {
      for (const std::uint32_t label : decoded(*codec, sample, brick, 0)) {
        ASSERT_GE(label, brick.range.min);
        ASSERT_LE(label, brick.range.max);
      }
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
      ++rejected;
    }
  }
  EXPECT_GT(rejected, 12);
}

TEST(LabelModel, WhatNoEncoderWritesIsCorrupt) {
  const auto kind_of = [](const LabelModel& model, VoxelType written, VoxelType read) {
    try {
      parse_label_weights(read, serialize(model, written));
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::internal;
  };
  const LabelWeightSet& start = label_start_weights();
  std::vector<std::int64_t> palette(kMaxPalette);
  std::iota(palette.begin(), palette.end(), -7);
  const LabelModel most(palette, start);
  EXPECT_EQ(kind_of(most, VoxelType::int32, VoxelType::int32), ErrorKind::internal);
  palette.push_back(palette.back() + 1);
  EXPECT_EQ(kind_of({palette, start}, VoxelType::int32, VoxelType::int32),
            ErrorKind::unsupported_version);
  for (const std::vector<std::int64_t>& beyond : {std::vector<std::int64_t>{256}, {255, 256}}) {
    EXPECT_EQ(kind_of({beyond, start}, VoxelType::uint16, VoxelType::uint16),
              ErrorKind::internal);
    EXPECT_EQ(kind_of({beyond, start}, VoxelType::uint16, VoxelType::uint8), ErrorKind::corrupt);
  }
  LabelWeightSet low = start;
  std::int8_t& weight = *std::ranges::find_if(
      low[1], [](int value) { return (value + 128) % kLabelWeightStep == 0; });
  weight = -126;
  EXPECT_EQ(kind_of({{}, low}, VoxelType::uint8, VoxelType::uint8), ErrorKind::internal);
  weight = -128;
  EXPECT_EQ(kind_of({{}, low}, VoxelType::uint8, VoxelType::uint8), ErrorKind::corrupt);
  Bytes longer = serialize({{}, start}, VoxelType::uint8);
  longer.insert(longer.end(), 16, std::uint8_t{1});
  EXPECT_THROW(parse_label_weights(VoxelType::uint8, longer), Error);
}

TEST(LabelPyramid, OfEquallyFrequentLabelsTheSmallestWins) {
  LabelBrick<std::int8_t> sample({2, 2, 2});
  sample.voxels = {5, 5, -3, -3, 5, 4, -3, 4};
  const LabelPyramid pyramid = build_label_pyramid(sample.shape, sample.view());
  EXPECT_EQ(pyramid.labels[pyramid.root().rank[0]], -3);
}

}  // namespace
}  // namespace octavo
