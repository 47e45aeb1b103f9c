#include "octavo/tasks/pictures/ray_mode.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/built_file.h"
#include "support/read_png.h"

namespace octavo {
namespace {

/// Values from 100 to 200, but `gap` in slabs along z and in others that lie along it.
testing::Volume with_gaps(float gap, double slope) {
  testing::Volume volume;
  volume.description.size = {24, 24, 24};
  volume.description.type = VoxelType::float32;
  volume.description.rescale = {slope, 0};
  for (int i = 0; i < 24 * 24 * 24; ++i) {
    const bool is_gap = i > 2 && (i % 24 < 8 || i / (24 * 24) % 5 == 2);
    const float value = i == 1 ? 100.0f : i == 2 ? 200.0f : 120.0f + static_cast<float>(i % 61);
    const float& stored = is_gap ? gap : value;
    const auto* const bytes = reinterpret_cast<const std::byte*>(&stored);
    volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof stored);
  }
  return volume;
}

TEST(RayMode, ExtremesPassOverWhatHasNoValue) {
  const testing::ScratchFolder folder;
  int built = 0;
  const auto drawn = [&](RenderMode mode, float gap, double slope) {
    RenderOptions options;
    options.input = folder.file("gaps" + std::to_string(built++) + ".8vo");
    testing::build_volume(with_gaps(gap, slope), options.input, 1);
    options.output = {folder.file("p.png"), true};
    options.mode = mode;
    options.width = options.height = 60;
    options.has_legend = options.has_scale_bar = options.has_sides = false;
    render(options, TaskContext{});
    const std::string bytes = testing::bytes_of_file(options.output.path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end())).pixels;
  };
  for (const double slope : {1.0, -1.0}) {
    for (const RenderMode mode : {RenderMode::mip, RenderMode::minip}) {
      const bool is_lowest = seeks_lowest(mode, {slope, 0});
      const auto gaps = drawn(mode, std::numeric_limits<float>::quiet_NaN(), slope);
      EXPECT_EQ(gaps, drawn(mode, is_lowest ? 200.0f : 100.0f, slope)) << slope;
      EXPECT_NE(gaps, drawn(mode, is_lowest ? 100.0f : 200.0f, slope)) << slope;
    }
  }
}

}  // namespace
}  // namespace octavo
