#include "octavo/ops/mask/file_mask.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A ball of soft values in a flat surrounding, with noise in one half.
template <class T>
testing::Volume ball(const Size3& size, double spacing_z_mm) {
  testing::Volume volume;
  volume.description.size = size;
  volume.description.type = voxel_type_of<T>();
  volume.description.geometry.spacing_mm = {1, 1, spacing_z_mm};
  std::mt19937 random(1);
  std::vector<T> voxels;
  for (std::int64_t z = 0; z < size.z; ++z)
    for (std::int64_t y = 0; y < size.y; ++y)
      for (std::int64_t x = 0; x < size.x; ++x) {
        const double r = std::hypot(static_cast<double>(x) - 60, static_cast<double>(y) - 60,
                                    (static_cast<double>(z) - 30) * spacing_z_mm);
        double value = r < 50 ? 100 - r : 10;
        if (x > 80) value += static_cast<double>(random() % 8);
        voxels.push_back(static_cast<T>(value));
      }
  volume.voxels.resize(voxels.size() * sizeof(T));
  std::memcpy(volume.voxels.data(), voxels.data(), volume.voxels.size());
  return volume;
}

// Holds the mask of every level against the voxels that the reader gives.
void expect_masks(const testing::Volume& volume, const BuildOptions& options,
                  const std::vector<std::vector<ValueWindow>>& windows) {
  const testing::ScratchFolder folder;
  const std::string path = folder.file("v.8vo");
  NoProgress progress;
  build_file(*make_memory_source(volume.description, volume.voxels), local_storage(), path, options,
             progress);
  const auto reader = testing::open_file(path);
  for (int level = 0; level < reader->levels().count(); ++level) {
    const Size3 size = reader->levels().size(level);
    const auto voxels = testing::read_box(*reader, box_of(size), level);
    for (const auto& asked : windows) {
      const MaskTree mask = mask_of_file(*reader, level, asked, progress);
      ASSERT_TRUE(is_valid(mask));
      ASSERT_EQ(mask.size(), size);
      with_voxel_type(volume.description.type, [&](auto id) {
        using T = typename decltype(id)::type;
        std::int64_t i = 0;
        for (std::int64_t z = 0; z < size.z; ++z)
          for (std::int64_t y = 0; y < size.y; ++y)
            for (std::int64_t x = 0; x < size.x; ++x) {
              T voxel;
              std::memcpy(&voxel, voxels.data() + i++ * static_cast<std::int64_t>(sizeof voxel),
                          sizeof voxel);
              bool is_asked = false;
              for (const ValueWindow& w : asked) {
                is_asked = is_asked || w.contains(static_cast<double>(voxel));
              }
              ASSERT_EQ(mask.contains({x, y, z}), is_asked) << x << ' ' << y << ' ' << z;
            }
      });
    }
  }
}

const std::vector<std::vector<ValueWindow>>& windows() {
  static const std::vector<std::vector<ValueWindow>> all = {
      {{60, kInfinity}}, {{10, 10}},           {{12, 40}, {55, 70}},
      {},                {{-kInfinity, 1000}}, {{200, 300}}};
  return all;
}

TEST(MaskOfFile, IsTheWindowOfGreyVoxels) {
  expect_masks(ball<std::int16_t>({130, 125, 140}, 1), {}, windows());
}

TEST(MaskOfFile, IsTheWindowWhereBricksAreFlat) {
  for (const double spacing : {2.0, 5.0, 16.0}) {
    expect_masks(ball<std::uint8_t>({100, 90, 70}, spacing), {}, windows());
  }
}

TEST(MaskOfFile, IsTheWindowOfLossyVoxels) {
  BuildOptions options;
  options.max_error = 3;
  expect_masks(ball<std::int16_t>({100, 90, 70}, 1), options, windows());
}

TEST(MaskOfFile, IsTheWindowOfFloats) {
  BuildOptions options;
  options.max_error = 0.01;
  expect_masks(ball<float>({100, 90, 70}, 1), options, windows());
}

TEST(MaskOfFile, IsTheWindowOfLabels) {
  BuildOptions options;
  options.kind = VolumeKind::labels;
  expect_masks(ball<std::uint8_t>({100, 90, 70}, 1), options, windows());
}

TEST(MaskOfFile, StopsAtTheLimitOfMemory) {
  const testing::ScratchFolder folder;
  testing::build_volume(ball<std::uint8_t>({70, 70, 70}, 1), folder.file("v.8vo"), 1);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  NoProgress progress;
  const std::vector<ValueWindow> windows = {{60, kInfinity}};
  const MaskTree mask = mask_of_file(*reader, 0, windows, progress);
  EXPECT_EQ(mask_of_file(*reader, 0, windows, progress, 1 << 20), mask);
  EXPECT_THROW(mask_of_file(*reader, 0, windows, progress, 1 << 10), Error);
}

TEST(MaskOfFile, RejectsALevelThatIsNotThere) {
  const testing::ScratchFolder folder;
  testing::build_volume(ball<std::uint8_t>({9, 9, 9}, 1), folder.file("v.8vo"), 1);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  NoProgress progress;
  EXPECT_THROW(mask_of_file(*reader, -1, {}, progress), Error);
  EXPECT_THROW(mask_of_file(*reader, reader->levels().count(), {}, progress), Error);
}

}  // namespace
}  // namespace octavo
