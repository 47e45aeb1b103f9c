#include "octavo/builder/float_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace octavo {
namespace {

std::vector<float> sorted(const std::vector<float>& values) {
  DistinctValues distinct;
  distinct.add(values);
  return distinct.sorted();
}

// Values at random codes, as a program that multiplies in double would have written them.
std::vector<float> values_of(double scale, double offset, int codes, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> code(-codes, codes);
  std::vector<float> values;
  for (int i = 0; i < 3000; ++i) {
    values.push_back(static_cast<float>(code(random) * scale + offset));
  }
  return values;
}

TEST(FloatGrid, TheScaleIsFoundAndHoldsForValuesNotSeenBefore) {
  const double slope = static_cast<double>(0.0123456789f);
  struct Case {
    double scale;
    double offset;
    int codes;
  };
  const Case cases[] = {{0.1, 0, 3000},     {0.001, 0, 100'000}, {1.0 / 3, 0, 5000},
                        {1.0 / 255, 0, 255}, {1.0 / 4095, 0, 9000}, {slope, 0, 32'000},
                        {0.5, -1000.3, 2000}, {0.25, 0.1, 500},   {1 / 3.7, -0.25, 3000},
                        {slope, 17.5, 4000},   {2.5e-7, 0, 30'000},
                        {0x1p-20, 0, 32'000}, {1e30, 0, 1000},    {1e-40, 0, 1000}};
  for (const Case& c : cases) {
    const auto coding = find_coding(sorted(values_of(c.scale, c.offset, c.codes)), {});
    ASSERT_TRUE(coding) << c.scale;
    EXPECT_DOUBLE_EQ(coding->scale, c.scale);
    for (const float v : values_of(c.scale, c.offset, c.codes, 2)) {
      ASSERT_TRUE(exact_code(*coding, v)) << v << " with scale " << c.scale;
    }
  }
}

TEST(FloatGrid, AHintComesFirst) {
  const std::vector<SampleCoding> hints = {{VoxelType::int32, 1, 0}};
  EXPECT_EQ(find_coding(sorted({0, 10, 20}), hints)->scale, 1);
  EXPECT_EQ(find_coding(sorted({0, 10, 20}), {})->scale, 10);
  EXPECT_EQ(find_coding(sorted({0, 0.5f, 20}), hints)->scale, 0.5);
}

TEST(FloatGrid, StepsNeedNotStandBesideEachOther) {
  EXPECT_EQ(find_coding(sorted({0, 6, 10, 15}), {})->scale, 1);
  EXPECT_EQ(find_coding(sorted({0.6f, 1.0f, -1.5f}), {})->scale, 0.1);
}

TEST(FloatGrid, ValuesFarFromZeroTellTheirStepByWhatLiesBetweenThem) {
  for (const double first : {10.1, 90.2, 901.4}) {
    std::vector<float> values = {0};
    for (const double steps : {0, 14, 16, 17, 18, 19, 21}) {
      values.push_back(static_cast<float>(first + steps * 0.1));
    }
    const auto coding = find_coding(sorted(values), {});
    ASSERT_TRUE(coding) << first;
    EXPECT_EQ(coding->scale, 0.1) << first;
  }
}

TEST(FloatGrid, FloatsOfSimilarSizeAreMultiplesOfTheirLastBit) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(1, 2);
  std::vector<float> values;
  for (int i = 0; i < 3000; ++i) values.push_back(value(random));
  const auto coding = find_coding(sorted(values), {});
  ASSERT_TRUE(coding);
  EXPECT_EQ(coding->scale, 0x1p-23);
}

TEST(FloatGrid, NoiseAcrossZeroHasNoScale) {
  std::mt19937 random(7);
  std::normal_distribution<float> value(0, 20);
  std::vector<float> values;
  for (int i = 0; i < 3000; ++i) values.push_back(value(random));
  EXPECT_FALSE(find_coding(sorted(values), {}));
}

TEST(FloatGrid, OneValueAndNoneHaveACoding) {
  for (const std::vector<float>& values :
       {std::vector<float>{}, {0}, {3.7f}, {-1e-45f}, {std::numeric_limits<float>::max()}}) {
    const auto coding = find_coding(values, {});
    ASSERT_TRUE(coding);
    for (const float v : values) EXPECT_TRUE(exact_code(*coding, v)) << v;
  }
}

TEST(FloatGrid, MinusZeroHasNoCode) {
  EXPECT_FALSE(exact_code({}, -0.0f));
  EXPECT_EQ(exact_code({}, 0.0f), 0);
}

TEST(DistinctValues, AreSortedFiniteAndAtMostSoMany) {
  DistinctValues distinct;
  distinct.add(std::vector<float>{3, -1, NAN, 3, HUGE_VALF, -0.0f, 0});
  EXPECT_EQ(distinct.sorted(), (std::vector<float>{-1, 0, 3}));
  std::vector<float> many(2 * DistinctValues::kMost);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<float>(i);
  distinct.add(many);
  EXPECT_EQ(distinct.count(), DistinctValues::kMost);
}

}  // namespace
}  // namespace octavo
