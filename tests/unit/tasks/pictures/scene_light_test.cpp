#include "octavo/tasks/pictures/scene_light.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "octavo/tasks/inputs.h"
#include "support/built_file.h"

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
