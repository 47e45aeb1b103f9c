#include "octavo/core/sample_coding.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "octavo/core/levels.h"

namespace octavo {
namespace {

TEST(SampleCoding, AVoxelIsOneRoundedProductOneRoundedSumAndOneFloat) {
  // Fused, 3 * 0.1 - 0.3 would be the rounding error of the product; unfused it is another number.
  const SampleCoding coding{VoxelType::int32, 0.1, -0.3};
  volatile double product = 3 * 0.1;
  EXPECT_EQ(coding.voxel_of(3), static_cast<float>(product - 0.3));
  EXPECT_NE(coding.voxel_of(3), static_cast<float>(std::fma(3.0, 0.1, -0.3)));
}

TEST(SampleCoding, NoVoxelIsInfinite) {
  constexpr float kMost = std::numeric_limits<float>::max();
  const SampleCoding coding{VoxelType::int32, 1e36, 0};
  EXPECT_EQ(coding.voxel_of(1000), kMost);
  EXPECT_EQ(coding.voxel_of(-1000), -kMost);
}

TEST(SampleCoding, CodesOfEveryTypeAreDecodedInPlace) {
  std::mt19937 random(3);
  for (const VoxelType type : {VoxelType::int8, VoxelType::uint8, VoxelType::int16,
                               VoxelType::uint16, VoxelType::int32, VoxelType::uint32}) {
    const SampleCoding coding{type, 0.37, 5};
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      std::vector<T> codes(101);
      for (T& code : codes) code = static_cast<T>(random());
      std::vector<float> voxels(codes.size());
      std::memcpy(voxels.data(), codes.data(), codes.size() * sizeof(T));
      decode_samples(coding, voxels.data(), voxels);
      for (std::size_t i = 0; i < codes.size(); ++i) {
        ASSERT_EQ(voxels[i], coding.voxel_of(static_cast<std::int64_t>(codes[i])));
      }
    });
  }
}

TEST(SampleCoding, OnlyUsableNumbersAreValid) {
  EXPECT_TRUE(is_valid(SampleCoding{}));
  for (const double scale : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_FALSE(is_valid(SampleCoding{VoxelType::int32, scale, 0}));
  }
  EXPECT_FALSE(is_valid(SampleCoding{VoxelType::int32, 1, HUGE_VAL}));
  EXPECT_FALSE(is_valid(SampleCoding{VoxelType::float32, 1, 0}));
}

TEST(VoxelCount, TwoToTheSixtyThreeIsTheFirstOneRejected) {
  EXPECT_THROW(checked_voxel_count({kMaxAxis, kMaxAxis, kMaxAxis}), Error);
  EXPECT_EQ(checked_voxel_count({kMaxAxis, kMaxAxis, kMaxAxis - 1}),
            kMaxAxis * kMaxAxis * (kMaxAxis - 1));
  EXPECT_THROW(checked_voxel_count({kMaxAxis + 1, 1, 1}), Error);
  EXPECT_THROW(checked_voxel_count({1, 0, 1}), Error);
}

}  // namespace
}  // namespace octavo
