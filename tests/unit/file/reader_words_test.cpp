// Bricks of labels read as words against the same bricks read as voxels.
#include <gtest/gtest.h>

#include "octavo/codec/label/label_word_bricks.h"
#include "octavo/core/error.h"
#include "octavo/file/repair/salvage.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using testing::ScratchFolder;

// Boxes of four labels, and a cube of noise.
testing::Volume some_labels(const Size3& size, double spacing_z_mm) {
  testing::Volume volume;
  volume.description.kind = VolumeKind::labels;
  volume.description.type = VoxelType::uint8;
  volume.description.size = size;
  volume.description.geometry.spacing_mm = {1, 1, spacing_z_mm};
  std::uint32_t noise = 1;
  for (std::int64_t z = 0; z < size.z; ++z)
    for (std::int64_t y = 0; y < size.y; ++y)
      for (std::int64_t x = 0; x < size.x; ++x) {
        noise = noise * 1664525 + 1013904223;
        std::int64_t label = (x / 50 + y / 70 + z / 90) % 4;
        if (x > 130 && y < 20) label = noise >> 29;
        volume.voxels.push_back(static_cast<std::byte>(label));
      }
  return volume;
}

void expect_words(const FileReader& reader) {
  LabelWords words;
  LabelWords expected;
  for (int tier = 0; tier < reader.levels().tier_count(); ++tier) {
    visit_cells(box_of(reader.levels().brick_grid(tier)), {1, 1, 1}, [&](const Index3& brick) {
      const BrickEntry entry = reader.brick(tier, brick);
      const Size3 size = reader.levels().brick_box(tier, brick).size();
      std::vector<std::uint8_t> voxels(static_cast<std::size_t>(size.voxel_count()));
      reader.read_brick(entry, 0, voxels.data());
      words_of_voxels(size, {voxels.begin(), voxels.end()}, expected);
      reader.read_words(entry, words);
      EXPECT_EQ(words, expected) << brick.x << ' ' << brick.y << ' ' << brick.z;
      return true;
    });
  }
}

TEST(ReadWords, AreThoseOfTheVoxels) {
  const ScratchFolder folder;
  int file = 0;
  for (const Size3& size : {Size3{1, 1, 1}, Size3{150, 70, 100}, Size3{67, 66, 3}}) {
    for (const double spacing_z_mm : {1.0, 4.0}) {
      const std::string path = folder.file(std::to_string(file++));
      testing::build_volume(some_labels(size, spacing_z_mm), path, 2);
      const auto reader = testing::open_file(path);
      expect_words(*reader);
      // Readers that know no short way take the long one.
      expect_words(SalvageReader(reader, {}));
    }
  }
}

TEST(ReadWords, GreyVolumesHaveNone) {
  const ScratchFolder folder;
  testing::Volume volume = some_labels({20, 20, 20}, 1);
  volume.description.kind = VolumeKind::grey;
  testing::build_volume(volume, folder.file("grey"), 1);
  const auto reader = testing::open_file(folder.file("grey"));
  LabelWords words;
  EXPECT_THROW(reader->read_words(reader->brick(0, {0, 0, 0}), words), Error);
  EXPECT_THROW(SalvageReader(reader, {}).read_words(reader->brick(0, {0, 0, 0}), words), Error);
}

}  // namespace
}  // namespace octavo
