#include "octavo/codec/exact/float_bins.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <vector>

#include "support/exact_codings.h"

namespace octavo::exact {
namespace {

using testing::kExactCodings;

constexpr float kInfiniteFloat = std::numeric_limits<float>::infinity();
constexpr float kMaxFloat = std::numeric_limits<float>::max();

const float kNotable[] = {0.0f,     -0.0f,   1e-45f,        -1e-45f,    1.1754944e-38f, 0.125f,
                          -0.125f,  0.1f,    0.375f,        1.0f,       -1.0f,          1000.25f,
                          1000.43f, 3e7f,    -16777216.0f,  1e30f,      -1e30f,         kMaxFloat,
                          -kMaxFloat, 0.05f,  std::nextafter(0.125f, 0.0f), 2.5f, -7e8f, 3.4e-39f};

TEST(FloatBins, RanksAreInTheOrderOfFloats) {
  EXPECT_EQ(rank_of(0.0f), 0);
  EXPECT_EQ(rank_of(-0.0f), -1);
  EXPECT_EQ(rank_of(float_of_bits(1)), 1);
  EXPECT_EQ(rank_of(kInfiniteFloat), kInfinityRank);
  for (const float v : kNotable) {
    EXPECT_EQ(bits_of(float_of(rank_of(v))), bits_of(v));
    for (const float w : kNotable) {
      if (v < w) {
        EXPECT_LT(rank_of(v), rank_of(w)) << v << " " << w;
      }
    }
  }
}

TEST(FloatBins, EveryFloatIsInTheBinOfItsCode) {
  std::mt19937 random(4);
  for (const SampleCoding& coding : kExactCodings) {
    const FloatBins bins(coding);
    std::vector<float> values(std::begin(kNotable), std::end(kNotable));
    for (int i = 0; i < 20000; ++i) {
      values.push_back(float_of_bits(static_cast<std::uint32_t>(random())));
    }
    for (const float v : values) {
      if (!std::isfinite(v)) continue;
      const std::int64_t code = bins.code_of(v);
      EXPECT_LE(std::abs(code), kLargestBin);
      EXPECT_TRUE(bins.bin_of(code, 0).contains(rank_of(v)))
          << v << " at " << coding.scale << " + " << coding.offset;
    }
  }
}

TEST(FloatBins, BinsLeaveNoFloatOutAndShareNone) {
  for (const SampleCoding& coding : kExactCodings) {
    const FloatBins bins(coding);
    for (const int short_bits : {0, 5, 23}) {
      for (std::int64_t code = -70; code < 70; ++code) {
        const FloatBin bin = bins.bin_of(code, short_bits);
        EXPECT_LE(bin.first, bin.end);
        EXPECT_EQ(bin.end, bins.bin_of(code + 1, short_bits).first);
      }
      EXPECT_EQ(bins.bin_of(-kLargestBin, 0).first, rank_of(-kMaxFloat));
      EXPECT_EQ(bins.bin_of(kLargestBin, 0).end, kInfinityRank);
    }
  }
}

}  // namespace
}  // namespace octavo::exact
