#include "octavo/mesh/surface_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace octavo {
namespace {

template <class T>
void expect_bits(const SurfaceField& field, const std::vector<T>& row) {
  for (int count = 0; count <= 64; ++count) {
    std::uint64_t expected = 0;
    for (int i = 0; i < count; ++i) {
      const auto value = static_cast<double>(row[static_cast<std::size_t>(i)]);
      bool is_inside = false;
      for (const InsideRange& range : field.inside) {
        is_inside = is_inside || (std::isfinite(value) && range.lowest <= value &&
                                  value <= range.highest);
      }
      if (is_inside) expected |= std::uint64_t{1} << i;
    }
    ASSERT_EQ(InsideTest<T>(field).bits(row.data(), count), expected);
  }
}

TEST(SurfaceFieldBits, AreThoseOfEachVoxel) {
  std::mt19937 random(5);
  std::vector<std::int16_t> shorts(64);
  std::vector<std::uint8_t> bytes(64);
  std::vector<float> floats(64);
  for (std::size_t i = 0; i < 64; ++i) {
    shorts[i] = static_cast<std::int16_t>(random() % 7 - 3);
    bytes[i] = static_cast<std::uint8_t>(random() % 5);
    floats[i] = static_cast<float>(random() % 9) / 4;
  }
  floats[3] = std::numeric_limits<float>::infinity();
  floats[9] = std::numeric_limits<float>::quiet_NaN();
  expect_bits(SurfaceField::of_grey(0.5, false, VoxelType::int16), shorts);
  expect_bits(SurfaceField::of_grey(-1, true, VoxelType::int16), shorts);
  expect_bits(SurfaceField::of_grey(1e9, false, VoxelType::int16), shorts);
  expect_bits(SurfaceField::of_grey(-1e9, false, VoxelType::int16), shorts);
  expect_bits(SurfaceField::of_labels({}), bytes);
  expect_bits(SurfaceField::of_labels(std::vector<std::int64_t>{1, 3}), bytes);
  expect_bits(SurfaceField::of_grey(1.1, false, VoxelType::float32), floats);
  expect_bits(SurfaceField::of_grey(1.25, true, VoxelType::float32), floats);
}

TEST(SurfaceFieldShare, OfARangeIsThatOfItsValues) {
  const SurfaceField field = SurfaceField::of_grey(10, false, VoxelType::int16);
  EXPECT_EQ(inside_share(field, 0, 9, false), InsideShare::none);
  EXPECT_EQ(inside_share(field, 10, 12, false), InsideShare::all);
  EXPECT_EQ(inside_share(field, 9, 10, false), InsideShare::some);
  EXPECT_EQ(inside_share(field, 10, 12, true), InsideShare::some);
  EXPECT_EQ(inside_share(field, 10, 10, true), InsideShare::all);
  const SurfaceField labels = SurfaceField::of_labels({});
  EXPECT_EQ(inside_share(labels, 1, 5, false), InsideShare::all);
  EXPECT_EQ(inside_share(labels, 0, 0, false), InsideShare::none);
  EXPECT_EQ(inside_share(labels, 0, 5, false), InsideShare::some);
}

TEST(SurfaceFieldCrossing, LiesHalfAStepBeforeWholeValuesAndNeverAtAVoxel) {
  const SurfaceField field = SurfaceField::of_grey(10, false, VoxelType::int16);
  const CrossingFinder<std::int16_t> crossing(field);
  const CrossingFinder<std::uint8_t> of_labels(SurfaceField::of_labels({}));
  EXPECT_DOUBLE_EQ(crossing.between(9, 10), 0.5);
  EXPECT_DOUBLE_EQ(crossing.between(12, 8), 0.625);
  EXPECT_DOUBLE_EQ(crossing.between(-30000, 10), 255.0 / 256);
  EXPECT_DOUBLE_EQ(crossing.between(10, -30000), 1.0 / 256);
  EXPECT_DOUBLE_EQ(of_labels.between(0, 7), 0.5);
  const SurfaceField floats = SurfaceField::of_grey(1, false, VoxelType::float32);
  const CrossingFinder<float> of_floats(floats);
  EXPECT_DOUBLE_EQ(of_floats.between(1, 0), 1.0 / 256);
  EXPECT_DOUBLE_EQ(of_floats.between(2, std::nanf("")), 0.5);
}

}  // namespace
}  // namespace octavo
