#include "octavo/ops/distance/distance_field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/dense_mask.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

constexpr Size3 kFieldSize = {37, 25, 83};
constexpr DistanceSettings kFieldSettings = {DistanceTo::faces, {0.5, 0.5, 0.75}};

/// All planes of a field, so many at a time.
std::vector<float> planes_of(DistanceField& field, std::int64_t at_once) {
  const std::int64_t plane = kFieldSize.x * kFieldSize.y;
  std::vector<float> all(static_cast<std::size_t>(kFieldSize.voxel_count()));
  for (std::int64_t z = 0; z < kFieldSize.z; z += at_once) {
    field.read(z, std::min(z + at_once, kFieldSize.z), all.data() + z * plane);
  }
  return all;
}

class DistanceFields : public ::testing::Test {
 protected:
  DistanceFields() {
    std::mt19937 random(3);
    mask_ = testing::tree_of(testing::random_mask(kFieldSize, random));
  }

  std::unique_ptr<DistanceField> made(const FieldPlan& plan, double limit) {
    return make_distance_field(inside_of(mask_), kFieldSettings, limit, plan, storage_, ".",
                               progress_);
  }

  MaskTree mask_;
  testing::MemoryStorage storage_;
  NoProgress progress_;
};

TEST_F(DistanceFields, OnDiskAreThoseInMemory) {
  const auto in_memory = made({}, HUGE_VAL);
  const auto on_disk = made({.hold = DistanceHold::disk, .bytes = 40000}, HUGE_VAL);
  EXPECT_EQ(planes_of(*on_disk, 5), planes_of(*in_memory, 7));
  EXPECT_EQ(on_disk->largest_mm(), in_memory->largest_mm());
}

TEST_F(DistanceFields, InAWindowAreThoseInMemoryUpToTheLimit) {
  constexpr double kLimit = 2.5;
  const auto in_memory = made({}, kLimit);
  FieldPlan plan = plan_distance_field(kFieldSize, kFieldSettings, kLimit, 150'000);
  ASSERT_EQ(plan.hold, DistanceHold::disk);
  plan = plan_distance_field({37, 25, 8300}, kFieldSettings, kLimit, 1'000'000);
  ASSERT_EQ(plan.hold, DistanceHold::window);
  const auto in_window = made(plan, kLimit);
  const std::vector<float> expected = planes_of(*in_memory, 83);
  for (const std::int64_t at_once : {1, 16, 64}) {
    EXPECT_EQ(planes_of(*in_window, at_once), expected);
  }
  // Backwards as well: planes may be asked for again.
  std::vector<float> first(static_cast<std::size_t>(kFieldSize.x * kFieldSize.y));
  in_window->read(0, 1, first.data());
  EXPECT_TRUE(std::equal(first.begin(), first.end(), expected.begin()));
}

TEST_F(DistanceFields, AreCutAtTheLimit) {
  const std::vector<float> free = planes_of(*made({}, HUGE_VAL), 83);
  const std::vector<float> cut = planes_of(*made({}, 1), 83);
  bool is_any_beyond = false;
  for (std::size_t i = 0; i < free.size(); ++i) {
    is_any_beyond = is_any_beyond || std::abs(free[i]) > 1;
    EXPECT_EQ(cut[i], std::clamp(free[i], -1.0F, 1.0F));
  }
  EXPECT_TRUE(is_any_beyond);
}

}  // namespace
}  // namespace octavo
