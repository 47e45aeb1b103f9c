#include "octavo/tasks/value_ranges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "octavo/core/text.h"

namespace octavo {
namespace {

VolumeDescription described(VoxelType type, Rescale rescale) {
  VolumeDescription volume;
  volume.type = type;
  volume.rescale = rescale;
  return volume;
}

TEST(ValueRanges, EndsOfFloatsAreRoundedToFloats) {
  const VolumeDescription volume = described(VoxelType::float32, {});
  for (int i = -1000; i <= 1000; ++i) {
    const double end = std::strtod((std::to_string(i) + "e-3").c_str(), nullptr);
    const auto voxel = static_cast<float>(end);
    for (const bool is_stored : {false, true}) {
      const ValueWindow window = stored_window({end, end}, volume, is_stored);
      EXPECT_TRUE(window.contains(voxel)) << end;
      EXPECT_FALSE(window.contains(std::nextafter(voxel, 2.0f))) << end;
      EXPECT_FALSE(window.contains(std::nextafter(voxel, -2.0f))) << end;
    }
  }
  // Ends beyond all floats hold all or none of them.
  constexpr float kMax = std::numeric_limits<float>::max();
  EXPECT_TRUE(stored_window({-1e300, 1e300}, volume, false).contains(kMax));
  EXPECT_FALSE(stored_window({1e300, 1e301}, volume, false).contains(kMax));
  EXPECT_FALSE(stored_window(AskedRange{}, volume, false)
                   .contains(std::numeric_limits<double>::infinity()));
}

TEST(ValueRanges, DecimalsFindTheIntegersThatAScaleOfFloatsMakesThem) {
  struct Case {
    const char* slope;
    const char* intercept;
    int decimals;
  };
  for (const Case& c : {Case{"0.1", "0", 1}, Case{"0.001", "0", 3}, Case{"-0.1", "0", 1},
                        Case{"0.01", "-10.3", 2}, Case{"0.7", "-1024", 1}}) {
    const double slope = std::strtod(c.slope, nullptr);
    const double intercept = std::strtod(c.intercept, nullptr);
    // As headers hold them: in binary64, and in binary32.
    const auto rounded = [](double real) { return static_cast<double>(static_cast<float>(real)); };
    for (const Rescale rescale :
         {Rescale{slope, intercept}, Rescale{rounded(slope), rounded(intercept)}}) {
      const VolumeDescription volume = described(VoxelType::int16, rescale);
      for (int stored = -32768; stored <= 32767; stored += 7) {
        const double power = std::pow(10, c.decimals);
        const double read = std::round((slope * stored + intercept) * power) / power;
        const ValueWindow window = stored_window({read, read}, volume, false);
        ASSERT_TRUE(window.contains(stored)) << c.slope << " " << stored;
        ASSERT_FALSE(window.contains(stored - 1)) << c.slope << " " << stored;
        ASSERT_FALSE(window.contains(stored + 1)) << c.slope << " " << stored;
      }
    }
  }
}

TEST(ValueRanges, IntegersAreFoundByTheFloatsThatReadersMakeOfThem) {
  for (const Rescale rescale : {Rescale{0.1, -1024}, Rescale{0.01, -1024}, Rescale{1.0 / 3, -1024},
                                Rescale{0.1, -100}, Rescale{-0.1, 1024}, Rescale{1, -0.1}}) {
    const VolumeDescription volume = described(VoxelType::int16, rescale);
    for (int stored = -128; stored < 128; ++stored) {
      const auto read = static_cast<double>(static_cast<float>(rescale.to_real(stored)));
      const ValueWindow window = stored_window({read, read}, volume, false);
      EXPECT_TRUE(window.contains(stored)) << rescale.slope << " " << stored;
      EXPECT_FALSE(window.contains(stored - 1) || window.contains(stored + 1)) << stored;
    }
  }
}

TEST(ValueRanges, EndsBetweenIntegersHoldNeither) {
  for (const Rescale rescale : {Rescale{0.1f, 0}, Rescale{1, -1024}, Rescale{2, 0.3}}) {
    const VolumeDescription volume = described(VoxelType::int32, rescale);
    const double real = (rescale.to_real(100) + rescale.to_real(101)) / 2;
    const ValueWindow window = stored_window({real, real}, volume, false);
    EXPECT_FALSE(window.contains(100));
    EXPECT_FALSE(window.contains(101));
  }
  // Whole numbers have no rounding: an end just beside one leaves it out.
  const VolumeDescription hounsfield = described(VoxelType::int32, {1, -1024});
  EXPECT_FALSE(stored_window({1e6 + 0.001, 2e6}, hounsfield, false).contains(1e6 + 1024));
  EXPECT_TRUE(stored_window({1e6, 2e6}, hounsfield, false).contains(1e6 + 1024));
}

TEST(ValueRanges, ScaledFloatsAreFoundByWhatIsReadOfThem) {
  const Rescale rescale{0.1f, static_cast<double>(-10.3f)};
  const VolumeDescription volume = described(VoxelType::float32, rescale);
  for (int i = 0; i < 1000; ++i) {
    const auto voxel = static_cast<float>(i) / 8;
    const double read = std::strtod(number_text(rescale.to_real(voxel)).c_str(), nullptr);
    if (std::abs(read - (0.0125 * i - 10.3)) > 1e-9) continue;  // has more digits than are shown
    EXPECT_TRUE(stored_window({read, read}, volume, false).contains(voxel)) << read;
  }
}

}  // namespace
}  // namespace octavo
