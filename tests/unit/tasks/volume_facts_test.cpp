#include "octavo/tasks/volume_facts.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "octavo/tasks/value_ranges.h"

namespace octavo {
namespace {

TEST(VolumeFacts, TheTextOfAValueFindsItsVoxelAlone) {
  const std::vector<Rescale> rescales = {
      {1e-9, 1}, {0.1, -1000.3}, {-1.0 / 3, 7}, {3, -1024}, {1, 0}, {1e-12, -1}, {1e35, 0}};
  for (const Rescale& rescale : rescales) {
    for (const VoxelType type : {VoxelType::int16, VoxelType::int32}) {
      VolumeDescription volume;
      volume.type = type;
      volume.rescale = rescale;
      const double last = type == VoxelType::int16 ? 32767 : 2147483647;
      for (const double stored : {-last, -12345.0, 0.0, 1.0, 12346.0, last - 1}) {
        const std::string text = real_text(volume, stored);
        const double read = std::strtod(text.c_str(), nullptr);
        const ValueWindow window = stored_window({read, read}, volume, false);
        EXPECT_TRUE(window.contains(stored)) << text << " " << rescale.slope;
        EXPECT_FALSE(window.contains(stored - 1)) << text << " " << rescale.slope;
        EXPECT_FALSE(window.contains(stored + 1)) << text << " " << rescale.slope;
      }
    }
  }
}

TEST(VolumeFacts, TheTextOfAValueHasNoMoreDigitsThanItNeeds) {
  VolumeDescription volume;
  volume.type = VoxelType::int16;
  volume.rescale = {0.1, 0};
  EXPECT_EQ(real_text(volume, 3), "0.3");
  volume.rescale = {1, -1024};
  EXPECT_EQ(real_text(volume, 24), "-1000");
  volume.type = VoxelType::float32;
  volume.rescale = {};
  EXPECT_EQ(real_text(volume, static_cast<double>(0.1F)), "0.1");
  EXPECT_EQ(real_text(volume, std::numeric_limits<double>::quiet_NaN()), "nan");
  EXPECT_EQ(real_text(volume, -std::numeric_limits<double>::infinity()), "-inf");
}

}  // namespace
}  // namespace octavo
