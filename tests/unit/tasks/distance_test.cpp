#include "octavo/tasks/distance.h"

#include <cmath>
#include <filesystem>

#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kCubeSize = {20, 20, 9};

class Distance : public testing::TaskFiles {
 protected:
  void SetUp() override {
    mask_ = {kCubeSize, std::vector<std::uint8_t>(20 * 20 * 9)};
    for_each_voxel({8, 8, 3}, [&](const Index3& p) { mask_.at({p.x + 6, p.y + 6, p.z + 3}) = 1; });
    options_.input = write("mask.8vo", mask_);
    options_.output = {folder_.file("out.8vo"), true};
  }

  /// Real values of what was written.
  std::vector<double> made() {
    const auto reader = testing::open_file(options_.output.path);
    const VolumeDescription& volume = reader->description();
    const std::vector<std::byte> bytes = testing::read_box(*reader, box_of(volume.size), 0);
    std::vector<double> values;
    with_voxel_type(volume.type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::size_t i = 0; i < bytes.size(); i += sizeof(T)) {
        T value;
        std::memcpy(&value, bytes.data() + i, sizeof value);
        values.push_back(volume.rescale.to_real(static_cast<double>(value)));
      }
    });
    return values;
  }

  static std::size_t place(std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::size_t>((z * kCubeSize.y + y) * kCubeSize.x + x);
  }

  DenseMask mask_;
  DistanceOptions options_;
};

TEST_F(Distance, CountsInMmFromFacesOrCenters) {
  const DistanceResult result = distance(options_, context_);
  EXPECT_EQ(result.volume.metadata.unit(), "mm");
  EXPECT_EQ(result.volume.kind, VolumeKind::grey);
  std::vector<double> mm = made();
  EXPECT_EQ(mm[place(6, 10, 4)], -0.25);   // half a voxel of 0.5 mm to the face
  EXPECT_EQ(mm[place(4, 10, 4)], 0.75);
  EXPECT_EQ(mm[place(10, 10, 2)], 1);      // half a voxel of 2 mm
  EXPECT_EQ(result.smallest_mm, -1.75);
  options_.to = DistanceTo::centers;
  distance(options_, context_);
  mm = made();
  EXPECT_EQ(mm[place(6, 10, 4)], -0.5);
  EXPECT_EQ(mm[place(10, 10, 2)], 2);
}

TEST_F(Distance, InStepsIsWithinHalfAStep) {
  distance(options_, context_);
  const std::vector<double> exact = made();
  options_.is_in_steps = true;
  for (const std::optional<double> step : {std::optional<double>(), std::optional(0.01)}) {
    options_.step_mm = step;
    const DistanceResult result = distance(options_, context_);
    EXPECT_EQ(result.volume.type, VoxelType::int16);
    const double half = result.volume.rescale.slope / 2 * (1 + 1e-6);
    EXPECT_EQ(result.volume.rescale.slope, step.value_or(result.volume.rescale.slope));
    const std::vector<double> in_steps = made();
    for (std::size_t i = 0; i < exact.size(); ++i) ASSERT_NEAR(in_steps[i], exact[i], half);
  }
}

TEST_F(Distance, WithALimitTakesStepsUpToTheLargestDistance) {
  options_.is_in_steps = true;
  options_.max_mm = 0.7;  // as a float less than as a double
  options_.step_mm = 0.7;
  const DistanceResult result = distance(options_, context_);
  EXPECT_EQ(result.largest_mm, static_cast<double>(0.7f));
  EXPECT_EQ(made()[place(0, 0, 0)], 0.7);
  // Within the limit, and longer than any distance: known at the last planes alone.
  options_.max_mm = 1000;
  options_.step_mm = 500;
  options_.output = {folder_.file("none.8vo"), false};
  EXPECT_EQ(failure_of([&] { distance(options_, context_); }).field, "distance.step_mm");
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
}

TEST_F(Distance, NeedsAMaskWithASurfaceAndGoodNumbers) {
  const auto failing = [&] { return failure_of([&] { distance(options_, context_); }); };
  options_.max_mm = -1;
  EXPECT_EQ(failing().field, "distance.max_mm");
  options_.max_mm.reset();
  options_.is_in_steps = true;
  options_.step_mm = 1e-6;
  EXPECT_EQ(failing().field, "distance.step_mm");
  options_.step_mm = 1e9;
  EXPECT_EQ(failing().field, "distance.step_mm");
  options_.step_mm.reset();
  options_.input = write("plain.8vo", mask_, false);
  EXPECT_EQ(failing().kind, ErrorKind::invalid_argument);
  for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{1}}) {
    std::fill(mask_.voxels.begin(), mask_.voxels.end(), value);
    options_.input = write("one" + std::to_string(value) + ".8vo", mask_);
    EXPECT_EQ(failing().kind, ErrorKind::invalid_argument);
  }
}

}  // namespace
}  // namespace octavo
