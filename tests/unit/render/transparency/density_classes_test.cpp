#include "octavo/render/transparency/density_classes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "octavo/core/error.h"

namespace octavo {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

VolumeDescription volume_of(VoxelType type, const Rescale& rescale = {}) {
  VolumeDescription volume;
  volume.type = type;
  volume.size = {4, 4, 4};
  volume.rescale = rescale;
  return volume;
}

const std::vector<DensityRange> kRanges = {
    {-100, 50, {}, 0.1}, {200, kInfinity, {}, 0.1}, {0, 100, {}, 0.1}};

TEST(DensityClasses, TheFirstRangeThatHasAValueCounts) {
  for (const VoxelType type : {VoxelType::int16, VoxelType::int32, VoxelType::float32}) {
    const DensityClasses map = DensityClasses::of_ranges(volume_of(type), kRanges);
    EXPECT_EQ(map.count(), 4U);
    EXPECT_EQ(map.class_of(-101), 0);
    EXPECT_EQ(map.class_of(-100), 1);
    EXPECT_EQ(map.class_of(50), 1);
    EXPECT_EQ(map.class_of(51), 3);
    EXPECT_EQ(map.class_of(150), 0);
    EXPECT_EQ(map.class_of(200), 2);
  }
}

TEST(DensityClasses, RangesAreRealValuesWhateverTheRescale) {
  for (const double slope : {0.5, -0.5, 3.0}) {
    const Rescale rescale{slope, -24};
    const DensityClasses map =
        DensityClasses::of_ranges(volume_of(VoxelType::int16, rescale), kRanges);
    const DensityClasses plain = DensityClasses::of_ranges(volume_of(VoxelType::float32), kRanges);
    for (int stored = -700; stored < 700; ++stored) {
      EXPECT_EQ(map.class_of(stored), plain.class_of(rescale.to_real(stored)));
    }
  }
}

TEST(DensityClasses, ACommonClassIsThatOfEveryValueBetween) {
  for (const double slope : {1.0, -2.0}) {
    const VolumeDescription volume = volume_of(VoxelType::int16, {slope, 0});
    const DensityClasses maps[] = {DensityClasses::of_ranges(volume, kRanges),
                                   DensityClasses::ramp(volume, -30, 90, 12)};
    for (const DensityClasses& map : maps) {
      int known = 0;
      for (int low = -250; low < 250; low += 7) {
        for (int high = low; high < 250; high += 9) {
          const auto common = map.common_class(low, high);
          if (!common) continue;
          ++known;
          for (int value = low; value <= high; ++value) ASSERT_EQ(map.class_of(value), *common);
        }
      }
      EXPECT_GT(known, 100);
    }
  }
}

TEST(DensityClasses, ARampOfAsManyStepsAsValuesIsExact) {
  const DensityClasses map = DensityClasses::ramp(volume_of(VoxelType::int16), -1000, 3000, 4000);
  EXPECT_EQ(map.count(), 4001U);
  for (int value = -1000; value <= 3000; ++value) EXPECT_EQ(map.class_of(value), value + 1000);
  EXPECT_EQ(map.class_of(-32768), 0);
  EXPECT_EQ(map.class_of(32767), 4000);
}

TEST(DensityClasses, AllVoxelsOfATypeAreMapped) {
  const std::vector<float> voxels = {-200, 0, 75, 500, std::nanf(""), INFINITY, -INFINITY};
  std::vector<std::uint16_t> classes(voxels.size());
  const auto count = static_cast<std::int64_t>(voxels.size());
  DensityClasses::of_ranges(volume_of(VoxelType::float32), kRanges)
      .map(voxels.data(), count, classes.data());
  EXPECT_EQ(classes, (std::vector<std::uint16_t>{0, 1, 3, 2, 0, 2, 0}));
  DensityClasses::ramp(volume_of(VoxelType::float32), 0, 100, 4)
      .map(voxels.data(), count, classes.data());
  EXPECT_EQ(classes, (std::vector<std::uint16_t>{0, 0, 3, 4, 0, 4, 0}));
  const std::vector<std::int8_t> bytes = {-128, -100, 0, 51, 127};
  classes.resize(bytes.size());
  DensityClasses::of_ranges(volume_of(VoxelType::int8), kRanges)
      .map(bytes.data(), static_cast<std::int64_t>(bytes.size()), classes.data());
  EXPECT_EQ(classes, (std::vector<std::uint16_t>{0, 1, 1, 3, 0}));
}

TEST(DensityClasses, RampsWithoutWidthOrStepsAreRejected) {
  const VolumeDescription volume = volume_of(VoxelType::int16);
  EXPECT_THROW(DensityClasses::ramp(volume, 5, 5, 1), Error);
  EXPECT_THROW(DensityClasses::ramp(volume, 0, kInfinity, 1), Error);
  EXPECT_THROW(DensityClasses::ramp(volume, 0, 1, 0), Error);
  EXPECT_THROW(DensityClasses::ramp(volume, 0, 1, 65536), Error);
}

}  // namespace
}  // namespace octavo
