#include "octavo/ops/label/label_masks.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <set>

#include "octavo/core/error.h"
#include "support/built_file.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const std::vector<ValueWindow> kAll = {{-kInfinity, kInfinity}};

/// Boxes of labels over each other, and grains of labels that stand nowhere else.
testing::Volume labeled(const Size3& size, std::mt19937& random, double spacing_z_mm = 1) {
  testing::Volume volume;
  volume.description.kind = VolumeKind::labels;
  volume.description.type = VoxelType::int16;
  volume.description.size = size;
  volume.description.geometry.spacing_mm = {1, 1, spacing_z_mm};
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (const std::int16_t label : {std::int16_t{3}, std::int16_t{-2}, std::int16_t{700}}) {
    const testing::DenseMask mask = testing::random_mask(size, random);
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      if (mask.voxels[i] != 0) voxels[i] = label;
    }
  }
  for (std::int16_t grain = 0; grain < 50; ++grain) {
    voxels[random() % voxels.size()] = static_cast<std::int16_t>(1000 + grain);
  }
  volume.voxels.resize(voxels.size() * sizeof voxels[0]);
  std::memcpy(volume.voxels.data(), voxels.data(), volume.voxels.size());
  return volume;
}

TEST(LabelMasks, AreTheVoxelsOfEachLabelAtEveryLevel) {
  std::mt19937 random(8);
  const testing::ScratchFolder folder;
  int number = 0;
  for (const Size3& size : {Size3{5, 3, 7}, Size3{130, 67, 21}, Size3{70, 70, 70}}) {
    const std::string path = folder.file(std::to_string(number++) + ".8vo");
    testing::build_volume(labeled(size, random, number == 2 ? 4 : 1), path, 2);
    const auto reader = testing::open_file(path);
    for (int level = 0; level < reader->levels().count(); ++level) {
      const Size3 samples = reader->levels().size(level);
      const auto bytes = testing::read_box(*reader, box_of(samples), level);
      std::vector<std::int16_t> voxels(bytes.size() / 2);
      std::memcpy(voxels.data(), bytes.data(), bytes.size());
      std::set<std::int64_t> labels(voxels.begin(), voxels.end());
      labels.erase(0);
      NoProgress progress;
      const auto masks = masks_of_labels(*reader, level, kAll, progress);
      ASSERT_EQ(masks.size(), labels.size());
      auto label = labels.begin();
      for (const LabelMask& mask : masks) {
        ASSERT_EQ(mask.label, *label++);
        testing::DenseMask dense{samples, std::vector<std::uint8_t>(voxels.size())};
        for (std::size_t i = 0; i < voxels.size(); ++i) dense.voxels[i] = voxels[i] == mask.label;
        ASSERT_EQ(mask.tree, testing::tree_of(dense));
      }
    }
  }
}

TEST(LabelMasks, WindowsChooseLabels) {
  std::mt19937 random(9);
  const testing::ScratchFolder folder;
  testing::build_volume(labeled({70, 66, 68}, random), folder.file("a.8vo"), 1);
  const auto reader = testing::open_file(folder.file("a.8vo"));
  NoProgress progress;
  const std::vector<ValueWindow> windows = {{-5, 2}, {700, 700}};
  const auto masks = masks_of_labels(*reader, 0, windows, progress);
  ASSERT_EQ(masks.size(), 2u);
  EXPECT_EQ(masks[0].label, -2);
  EXPECT_EQ(masks[1].label, 700);
}

TEST(LabelMasks, WhatHasNoLabelsIsRejected) {
  std::mt19937 random(10);
  const testing::ScratchFolder folder;
  testing::Volume volume = labeled({70, 66, 68}, random);
  testing::build_volume(volume, folder.file("a.8vo"), 1);
  volume.description.kind = VolumeKind::grey;
  testing::build_volume(volume, folder.file("g.8vo"), 1);
  NoProgress progress;
  const auto labels = testing::open_file(folder.file("a.8vo"));
  EXPECT_THROW(masks_of_labels(*labels, 99, kAll, progress), Error);
  EXPECT_THROW(masks_of_labels(*labels, 0, kAll, progress, 1000), Error);
  const auto grey = testing::open_file(folder.file("g.8vo"));
  EXPECT_THROW(masks_of_labels(*grey, 0, kAll, progress), Error);
}

}  // namespace
}  // namespace octavo
