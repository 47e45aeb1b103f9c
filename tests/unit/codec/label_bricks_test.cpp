// Bricks of labels as words against the same bricks as voxels.
#include "octavo/codec/label_bricks.h"

#include <gtest/gtest.h>

#include <limits>

#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/core/error.h"
#include "support/label_brick.h"

namespace octavo {
namespace {

using testing::LabelBrick;

template <class T>
LabelWords words_of(const LabelBrick<T>& sample) {
  LabelWords words;
  words_of_voxels(sample.shape.size[0], {sample.voxels.begin(), sample.voxels.end()}, words);
  return words;
}

template <class T>
void expect_same(const BrickCodec& codec, const LabelBrick<T>& sample) {
  const LabelBrickCodec& labels = as_label_codec(codec);
  const LabelWords words = words_of(sample);
  const EncodedBrick of_voxels = codec.encode(sample.shape, sample.view());
  const EncodedBrick of_words = labels.encode_words(sample.shape, words);
  EXPECT_EQ(of_words.range, of_voxels.range);
  EXPECT_EQ(of_words.parent, of_voxels.parent);
  EXPECT_EQ(of_words.max_error, of_voxels.max_error);
  ASSERT_EQ(of_words.segments, of_voxels.segments);
  LabelWords decoded;
  labels.decode_words(sample.shape, of_words.range, testing::spans(of_words), decoded);
  EXPECT_EQ(decoded, words);
}

const std::vector<Size3> kBrickSizes = {
    {64, 64, 64}, {1, 1, 1},    {1, 1, 2},  {2, 2, 2},  {3, 3, 3},   {4, 4, 4},
    {5, 7, 11},   {63, 62, 61}, {64, 1, 1}, {2, 2, 64}, {37, 64, 5}, {13, 29, 31},
    {1, 1, 5},    {1, 5, 5},    {5, 5, 1}};

template <class T>
class LabelBricksOfType : public ::testing::Test {};
TYPED_TEST_SUITE(LabelBricksOfType, testing::LabelTypes);

TYPED_TEST(LabelBricksOfType, WordsAndVoxelsHaveTheSameBytes) {
  using T = TypeParam;
  const T low = std::numeric_limits<T>::min();
  const T high = std::numeric_limits<T>::max();
  const auto codec = train_label_model(voxel_type_of<T>(), {});
  for (const Size3& size : kBrickSizes) {
    for (const Point3& spacing : {Point3{1, 1, 1}, Point3{1, 1, 2}, Point3{4, 1, 1}}) {
      expect_same(*codec, testing::balls<T>(size, {3, low, T(5), high, T(7), T(0)}, spacing));
      expect_same(*codec, testing::balls<T>(size, {0, 1}, spacing));
    }
  }
}

TEST(LabelBricks, NoiseOfFewAndOfManyLabelsHasTheSameBytes) {
  const auto codec = train_label_model(VoxelType::uint32, {});
  for (const Size3& size : {Size3{21, 12, 17}, Size3{64, 64, 64}}) {
    // The last ones are stored, not coded.
    for (const std::uint64_t count : {2u, 70u, 0u}) {
      expect_same(*codec, testing::noise<std::uint32_t>(size, 3, count));
    }
  }
}

TEST(LabelBricks, OneWorkSpaceServesBricksOfAllShapes) {
  const auto codec = train_label_model(VoxelType::uint8, {});
  for (const Size3& size : {Size3{64, 64, 64}, Size3{5, 5, 5}, Size3{64, 64, 64}}) {
    for (const std::uint64_t seed : {1u, 2u}) {
      expect_same(*codec, testing::noise<std::uint8_t>(size, seed, 3));
      expect_same(*codec, testing::balls<std::uint8_t>(size, {1, 2}));
    }
  }
}

TEST(LabelBricks, TrainingOnWordsGivesTheModelOfTheVoxels) {
  for (const Point3& spacing : {Point3{1, 1, 1}, Point3{1, 1, 3}}) {
    std::vector<LabelBrick<std::uint8_t>> samples;
    for (const Size3& size : {Size3{64, 64, 64}, Size3{40, 64, 33}, Size3{9, 9, 9}}) {
      samples.push_back(testing::balls<std::uint8_t>(size, {4, 2, 9, 1}, spacing));
    }
    std::vector<TrainingBrick> voxels;
    std::vector<BrickShape> shapes;
    for (const auto& sample : samples) {
      voxels.push_back(sample.training());
      shapes.push_back(sample.shape);
    }
    const auto take = [&](std::size_t i, LabelWords& words) { words = words_of(samples[i]); };
    EXPECT_EQ(train_label_words(VoxelType::uint8, shapes, take)->serialized(),
              train_label_model(VoxelType::uint8, voxels)->serialized());
  }
}

TEST(LabelBricks, WhatNoFileCanHoldIsRejected) {
  const auto codec = train_label_model(VoxelType::uint8, {});
  const auto sample = testing::balls<std::int16_t>({16, 16, 16}, {1, 256});
  EXPECT_THROW(as_label_codec(*codec).encode_words(sample.shape, words_of(sample)), Error);
  const auto grey = train_grey_model(VoxelType::uint8, {});
  EXPECT_THROW(as_label_codec(*grey), Error);
}

TEST(LabelBricks, DamagedBytesGiveWordsOrAnError) {
  const auto codec = train_label_model(VoxelType::uint8, {});
  const auto sample = testing::balls<std::uint8_t>({64, 48, 33}, {1, 2, 3, 4});
  const EncodedBrick whole = codec->encode(sample.shape, sample.view());
  std::mt19937 random(8);
  int read = 0;
  for (int round = 0; round < 300; ++round) {
    EncodedBrick damaged = whole;
    Bytes& segment = damaged.segments[random() % damaged.segments.size()];
    if (segment.empty()) continue;
    segment[random() % segment.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    LabelWords words;
    std::vector<std::uint8_t> voxels(sample.voxels.size());
    try {
      as_label_codec(*codec).decode_words(sample.shape, damaged.range, testing::spans(damaged),
                                          words);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
      EXPECT_THROW(testing::decoded(*codec, sample, damaged, 0), Error);
      continue;
    }
    ++read;
    LabelBrick<std::uint8_t> other = sample;
    other.voxels = testing::decoded(*codec, sample, damaged, 0);
    EXPECT_EQ(words, words_of(other));
  }
  EXPECT_GT(read, 0);
}

}  // namespace
}  // namespace octavo
