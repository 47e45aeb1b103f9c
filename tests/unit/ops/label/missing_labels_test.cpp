#include "octavo/ops/label/missing_labels.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <set>

#include "support/built_file.h"

namespace octavo {
namespace {

/// Blocks of label 3, and grains of labels of their own far apart.
testing::Volume grains(std::mt19937& random) {
  testing::Volume volume;
  volume.description.kind = VolumeKind::labels;
  volume.description.type = VoxelType::int16;
  volume.description.size = {150, 70, 66};
  std::vector<std::int16_t> voxels(
      static_cast<std::size_t>(volume.description.size.voxel_count()));
  std::fill_n(voxels.begin(), voxels.size() / 3, std::int16_t{3});
  for (std::int16_t grain = 0; grain < 40; ++grain) {
    voxels[random() % voxels.size()] = static_cast<std::int16_t>(2 * grain - 40);
  }
  volume.voxels.resize(voxels.size() * sizeof voxels[0]);
  std::memcpy(volume.voxels.data(), voxels.data(), volume.voxels.size());
  return volume;
}

TEST(MissingLabels, AreThoseThatNoVoxelOfTheLevelHas) {
  std::mt19937 random(20);
  const testing::ScratchFolder folder;
  const std::string path = folder.file("grains.8vo");
  testing::build_volume(grains(random), path, 2);
  const auto reader = testing::open_file(path);
  for (int level = 0; level < reader->levels().count(); ++level) {
    const auto bytes = testing::read_box(*reader, box_of(reader->levels().size(level)), level);
    std::vector<std::int16_t> voxels(bytes.size() / 2);
    std::memcpy(voxels.data(), bytes.data(), bytes.size());
    const std::set<std::int64_t> there(voxels.begin(), voxels.end());
    std::vector<std::int64_t> asked;
    std::vector<std::int64_t> expected;
    for (std::int64_t label = -70000; label < 70000; label += label < -50 || label > 50 ? 999 : 1) {
      asked.push_back(label);
      if (!there.contains(label)) expected.push_back(label);
    }
    EXPECT_EQ(missing_labels(*reader, level, asked, NoProgress()), expected) << "level " << level;
  }
  EXPECT_TRUE(missing_labels(*reader, 0, {}, NoProgress()).empty());
}

}  // namespace
}  // namespace octavo
