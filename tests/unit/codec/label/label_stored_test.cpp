// Bricks of labels that coding would enlarge.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "octavo/core/error.h"
#include "support/label_brick.h"

namespace octavo {
namespace {

using testing::byte_count;
using testing::decoded;
using testing::LabelBrick;
using testing::noise;
using testing::spans;

bool is_stored(const EncodedBrick& brick) { return brick.segments.back().empty(); }

/// What a brick of noise costs, as a share of its voxels' bytes.
template <class T>
double noise_share(std::uint64_t count) {
  const auto sample = noise<T>({64, 64, 64}, 7, count);
  const auto codec = train_label_model(voxel_type_of<T>(), {});
  const EncodedBrick brick = codec->encode(sample.shape, sample.view());
  EXPECT_TRUE(is_stored(brick));
  EXPECT_EQ(decoded(*codec, sample, brick, 0), sample.voxels);
  return static_cast<double>(byte_count(brick)) /
         static_cast<double>(sample.voxels.size() * sizeof(T));
}

TEST(StoredLabels, NoiseGrowsByLessThanTwoHundredthsOfAPercent) {
  EXPECT_LT(noise_share<std::uint8_t>(0), 1.0002);
  EXPECT_LT(noise_share<std::uint16_t>(0), 1.0002);
  EXPECT_LT(noise_share<std::uint32_t>(0), 1.0002);
}

TEST(StoredLabels, NoiseOfFewLabelsCostsTheBitsOfTheirNumber) {
  EXPECT_LT(noise_share<std::uint8_t>(2), 1.0 / 8 * 1.0002);
  EXPECT_LT(noise_share<std::uint8_t>(6), 3.0 / 8 * 1.0002);
  EXPECT_LT(noise_share<std::uint16_t>(256), 8.0 / 16 * 1.0002 + 0.001);
}

TEST(StoredLabels, ScatteredLabelsAreListed) {
  auto sample = noise<std::uint32_t>({32, 32, 32}, 8, 5);
  for (std::uint32_t& voxel : sample.voxels) voxel *= 1000000007u;
  const auto codec = train_label_model(VoxelType::uint32, {});
  const EncodedBrick brick = codec->encode(sample.shape, sample.view());
  EXPECT_LT(byte_count(brick), sample.voxels.size() * 3 / 8 + 32);
  EXPECT_EQ(decoded(*codec, sample, brick, 0), sample.voxels);
}

TEST(StoredLabels, MoreLabelsThanSlotsComeBackAtEveryLevel) {
  LabelBrick<std::int32_t> sample({64, 64, 64});
  for (std::size_t i = 0; i < sample.voxels.size(); ++i) {
    sample.voxels[i] = static_cast<std::int32_t>(i / 8) - 7;
  }
  const auto codec = train_label_model(VoxelType::int32, {});
  const EncodedBrick brick = codec->encode(sample.shape, sample.view());
  EXPECT_TRUE(is_stored(brick));
  EXPECT_EQ(decoded(*codec, sample, brick, 0), sample.voxels);
  EXPECT_EQ(decoded(*codec, sample, brick, 1)[0], -7);
  EXPECT_EQ(decoded(*codec, sample, brick, 5)[0], -7);
}

TEST(StoredLabels, DamageIsRejectedOrDecodesToSomething) {
  const auto sample = noise<std::uint8_t>({16, 16, 16}, 9, 6);
  const auto codec = train_label_model(VoxelType::uint8, {});
  const EncodedBrick brick = codec->encode(sample.shape, sample.view());
  ASSERT_TRUE(is_stored(brick));
  const auto is_rejected = [&](const EncodedBrick& damaged) {
    try {
      decoded(*codec, sample, damaged, 0);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
      return true;
    }
    return false;
  };
  for (std::size_t length = 0; length < brick.segments[0].size(); ++length) {
    EncodedBrick damaged = brick;
    damaged.segments[0].resize(length);
    EXPECT_TRUE(is_rejected(damaged)) << length;
  }
  EncodedBrick longer = brick;
  longer.segments[0].push_back(0);
  EXPECT_TRUE(is_rejected(longer));
  EncodedBrick twice = brick;
  twice.segments[1].push_back(0);
  EXPECT_TRUE(is_rejected(twice));
  EncodedBrick beyond = brick;
  std::fill(beyond.segments[0].begin() + 8, beyond.segments[0].end(), std::uint8_t{0xff});
  EXPECT_TRUE(is_rejected(beyond));
  for (std::size_t i = 0; i < 8; ++i) {
    EncodedBrick damaged = brick;
    for (int value = 0; value < 256; ++value) {
      damaged.segments[0][i] = static_cast<std::uint8_t>(value);
      is_rejected(damaged);
    }
  }
}

}  // namespace
}  // namespace octavo
