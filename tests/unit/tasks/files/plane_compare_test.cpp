#include "octavo/tasks/files/plane_compare.h"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <vector>

#include "octavo/planes/memory_source.h"

namespace octavo {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Comparison compared(const std::vector<float>& a, const std::vector<float>& b, double tolerance) {
  VolumeDescription description;
  description.type = VoxelType::float32;
  description.size = {static_cast<std::int64_t>(a.size()), 1, 1};
  const auto source_a = make_memory_source(description, std::as_bytes(std::span(a)));
  const auto source_b = make_memory_source(description, std::as_bytes(std::span(b)));
  NoProgress progress;
  return compare_planes(*source_a, *source_b, tolerance, progress);
}

TEST(PlaneCompare, OtherBitsOfOneValueAreCountedApart) {
  const float other_nan = std::bit_cast<float>(0x7fc01234u);
  const Comparison c = compared({0.0f, kNan, 5.0f, 1.0f}, {-0.0f, other_nan, 5.0f, 2.0f}, 0);
  EXPECT_EQ(c.other_bits, 2);
  EXPECT_EQ(c.different, 1);
  const Comparison equal_values = compared({0.0f, kNan}, {-0.0f, other_nan}, 0);
  EXPECT_TRUE(equal_values.is_equal());
  EXPECT_FALSE(equal_values.is_same_data());
  EXPECT_TRUE(compared({-0.0f, kNan}, {-0.0f, kNan}, 0).is_same_data());
}

TEST(PlaneCompare, WithinAToleranceBitsAreOfNoAccount) {
  const Comparison c = compared({0.0f, 1.0f}, {-0.0f, 1.5f}, 0.5);
  EXPECT_EQ(c.other_bits, 0);
  EXPECT_TRUE(c.is_same_data());
}

TEST(PlaneCompare, NanIsNoNumber) {
  EXPECT_EQ(compared({kNan}, {0.0f}, 1e9).different, 1);
  const Comparison c = compared({1.0f, kNan, 0.0f, kNan}, {1.5f, 2.0f, 0.0f, kNan}, 0);
  EXPECT_EQ(c.different, 2);
  EXPECT_EQ(c.nan_in_one, 1);
  EXPECT_EQ(c.max_difference, 0.5);
}

}  // namespace
}  // namespace octavo
