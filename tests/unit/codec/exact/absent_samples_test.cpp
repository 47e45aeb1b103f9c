#include "octavo/codec/exact/absent_samples.h"

#include <gtest/gtest.h>

#include <vector>

namespace octavo::exact {
namespace {

TEST(AbsentSamples, FlagsOfALevelFollowThoseAbove) {
  const Size3 size{5, 3, 2};
  AbsentFlags flags(30);
  for (const std::size_t i : {0u, 1u, 5u, 6u, 15u, 16u, 20u, 21u, 29u}) flags[i] = 1;
  const AbsentFlags coarse = coarser_flags(flags, size, 7);
  ASSERT_EQ(coarse.size(), 6u);
  EXPECT_EQ(coarse, (AbsentFlags{1, 0, 0, 0, 0, 0}));
  const Bytes coded = encode_absent(flags, size, coarse, 7, {});
  EXPECT_EQ(decode_absent(coded, size, coarse, 7, {}), flags);
}

// 3 x 3 voxels in cubes of 4, 2, 2 and 1.
class FilledSamples : public ::testing::Test {
 protected:
  std::vector<std::int32_t> filled(const AbsentFlags& flags, std::vector<std::int32_t> codes) {
    const Size3 size{3, 3, 1};
    const Levels levels(size, choose_halvings(size, {1, 1, 1}));
    fill_absent(brick_shape(levels, 0, {0, 0, 0}), flags, codes);
    return codes;
  }
};

TEST_F(FilledSamples, WhatIsAbsentBecomesTheMeanBesideIt) {
  EXPECT_EQ(filled({0, 1, 0, 0, 0, 0, 0, 0, 0}, {5, -99, 80, 7, 9, 80, 40, 40, 3}),
            (std::vector<std::int32_t>{5, 7, 80, 7, 9, 80, 40, 40, 3}));
}

TEST_F(FilledSamples, CubesAtTheBorderWeighByTheVoxelsInside) {
  // (4 * 0 + 2 * 80 + 2 * 40) / 8
  EXPECT_EQ(filled({0, 0, 0, 0, 0, 0, 0, 0, 1}, {0, 0, 80, 0, 0, 80, 40, 40, -99}),
            (std::vector<std::int32_t>{0, 0, 80, 0, 0, 80, 40, 40, 30}));
}

TEST_F(FilledSamples, AbsentVoxelsInsideWeighAsWell) {
  EXPECT_EQ(filled({0, 1, 0, 1, 1, 1, 0, 0, 1}, {0, -99, 80, -99, -99, -99, 40, 40, -99}),
            (std::vector<std::int32_t>{0, 0, 80, 0, 0, 80, 40, 40, 30}));
}

TEST_F(FilledSamples, WithoutAnyPresentAllCodesAreZero) {
  EXPECT_EQ(filled(AbsentFlags(9, 1), std::vector<std::int32_t>(9, -99)),
            std::vector<std::int32_t>(9, 0));
}

}  // namespace
}  // namespace octavo::exact
