#include "octavo/tasks/pictures/scene_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "octavo/core/error.h"
#include "octavo/tasks/inputs.h"
#include "support/built_file.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

/// A floor of 100 up to z = 8, in a room of 64 x 64 x 32 voxels.
std::shared_ptr<const FileReader> floor_file(const std::string& path) {
  testing::Volume volume;
  volume.description.size = {64, 64, 32};
  volume.description.type = VoxelType::uint8;
  for (std::int64_t i = 0; i < 64 * 64 * 32; ++i) {
    volume.voxels.push_back(static_cast<std::byte>(i < 64 * 64 * 8 ? 100 : 0));
  }
  testing::build_volume(volume, path, 1);
  return open_volume(path, {});
}

TEST(SceneLight, KeepsToWhatIsShown) {
  const testing::ScratchFolder folder;
  const auto reader = floor_file(folder.file("floor.8vo"));
  SceneMatter matter;
  matter.extinction = [](const SceneMatter::Cell& cell) { return cell.value > 50 ? 5.0 : 0.0; };
  matter.kept = box_of({64, 64, 32});
  EXPECT_LT(scene_light(*reader, 0, matter, {})->ambient_at({32, 32, 4}), 0.2f);
  matter.removed = {{{0, 0, 0}, {64, 64, 8}}};
  EXPECT_EQ(scene_light(*reader, 0, matter, {})->ambient_at({32, 32, 1}), 1.0f);
  matter.removed.clear();
  matter.kept.lo.z = 8;
  EXPECT_EQ(scene_light(*reader, 0, matter, {})->ambient_at({32, 32, 1}), 1.0f);
}

TEST(SceneLight, KnowsHowSteepValuesAre) {
  const testing::ScratchFolder folder;
  const auto reader = floor_file(folder.file("floor.8vo"));
  SceneMatter matter;
  double steepest = 0;
  matter.extinction = [&](const SceneMatter::Cell& cell) {
    steepest = std::max(steepest, cell.gradient);
    EXPECT_EQ(cell.side_mm, 1);
    return 0.0;
  };
  matter.kept = box_of({64, 64, 32});
  scene_light(*reader, 0, matter, {});
  EXPECT_EQ(steepest, 0);
  matter.has_gradient = true;
  scene_light(*reader, 0, matter, {});
  EXPECT_EQ(steepest, 50);
}

TEST(SceneLight, HasNoGradientAtWhatIsNoNumber) {
  const testing::ScratchFolder folder;
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {std::nanf(""), infinity, -infinity}) {
    // A ramp of 3 a voxel along x, from 500 on, and a box that is no number.
    testing::Volume volume;
    volume.description.size = {20, 16, 12};
    volume.description.type = VoxelType::float32;
    testing::for_each_voxel(volume.description.size, [&](const Index3& p) {
      const bool is_box = box_of({20, 16, 6}).contains(p) && p.x > 6 && p.y > 5;
      const float voxel = is_box ? value : static_cast<float>(500 + 3 * p.x);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
      volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof voxel);
    });
    testing::build_volume(volume, folder.file("box.8vo"), 1);
    const auto reader = open_volume(folder.file("box.8vo"), {});
    SceneMatter matter;
    matter.kept = box_of({20, 16, 12});
    matter.has_gradient = true;
    double steepest = 0;
    double lowest = infinity;
    double highest = -infinity;
    matter.extinction = [&](const SceneMatter::Cell& cell) {
      steepest = std::max(steepest, cell.gradient);
      lowest = std::min(lowest, cell.value);
      highest = std::max(highest, cell.value);
      return 0.0;
    };
    scene_light(*reader, 0, matter, {});
    EXPECT_EQ(steepest, 3);
    EXPECT_EQ(lowest, 500);
    EXPECT_EQ(highest, 557);
    std::filesystem::remove(folder.file("box.8vo"));
  }
}

TEST(SceneLight, MemoryIsLimited) {
  const testing::ScratchFolder folder;
  const auto reader = floor_file(folder.file("floor.8vo"));
  TaskContext context;
  context.max_memory_bytes = 1'000'000;
  EXPECT_THROW(scene_light(*reader, 0, {}, context), Error);
}

TEST(SceneLight, BoxesOfLevelsCoverThemselves) {
  const testing::ScratchFolder folder;
  const auto reader = floor_file(folder.file("floor.8vo"));
  EXPECT_EQ(box_at_level({{1, 2, 3}, {64, 5, 31}}, reader->levels(), 1),
            (Box{{1, 1, 2}, {32, 3, 16}}));
}

}  // namespace
}  // namespace octavo
