#include "octavo/render/slice/slice_picture.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "octavo/render/label_color.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using testing::ScratchFolder;
using testing::Volume;

/// Voxel (x, y, z) holds x + 8 y + 64 z.
Volume numbered_volume(const Geometry& geometry, const Rescale& rescale = {}) {
  Volume volume;
  volume.description.type = VoxelType::int16;
  volume.description.size = {8, 8, 8};
  volume.description.geometry = geometry;
  volume.description.rescale = rescale;
  volume.voxels.resize(1024);
  for (std::int16_t i = 0; i < 512; ++i) std::memcpy(volume.voxels.data() + 2 * i, &i, 2);
  return volume;
}

std::shared_ptr<FileReader> built(const ScratchFolder& folder, const Volume& volume) {
  testing::build_volume(volume, folder.file("a.8vo"), 1);
  return testing::open_file(folder.file("a.8vo"));
}

SliceOptions plain(int axis, std::int64_t index) {
  SliceOptions options;
  options.axis = axis;
  options.index = index;
  options.window = Window{255.5, 511};
  options.scale_bar = options.sides = false;
  options.least_side = 1;
  return options;
}

int shade(const SlicePicture& slice, std::int64_t x, std::int64_t y) {
  return slice.picture.pixels[static_cast<std::size_t>(y * slice.picture.width + x)];
}

int shade_of(int x, int y, int z) { return Window{255.5, 511}.grey(x + 8 * y + 64 * z); }

TEST(SlicePicture, SlicesOfAnUprightScanFollowTheConvention) {
  const ScratchFolder folder;
  const auto reader = built(folder, numbered_volume({}));
  const SlicePicture axial = render_slice(*reader, plain(2, 3));
  EXPECT_EQ(shade(axial, 0, 0), shade_of(0, 0, 3));
  EXPECT_EQ(shade(axial, 7, 1), shade_of(7, 1, 3));
  EXPECT_EQ(axial.orientation.left, 'R');
  EXPECT_EQ(axial.orientation.top, 'A');
  const SlicePicture coronal = render_slice(*reader, plain(1, 2));
  EXPECT_EQ(shade(coronal, 6, 0), shade_of(6, 2, 7));
  EXPECT_EQ(coronal.orientation.left, 'R');
  EXPECT_EQ(coronal.orientation.top, 'S');
  const SlicePicture sagittal = render_slice(*reader, plain(0, 5));
  EXPECT_EQ(shade(sagittal, 1, 7), shade_of(5, 1, 0));
  EXPECT_EQ(sagittal.orientation.left, 'A');
  EXPECT_EQ(sagittal.orientation.bottom, 'I');
}

TEST(SlicePicture, FlippedAndSwappedAxesAreTurnedUpright) {
  const ScratchFolder folder;
  Geometry geometry;
  // Index x runs up, y to the right of the patient, z to the front: a coronal stack from the back.
  geometry.direction = {0, -0.999, 0.04, 0, -0.04, -0.999, 1, 0, 0};
  const auto reader = built(folder, numbered_volume(geometry));
  const SlicePicture coronal = render_slice(*reader, plain(2, 4));
  EXPECT_EQ(coronal.orientation.left, 'R');
  EXPECT_EQ(coronal.orientation.right, 'L');
  EXPECT_EQ(coronal.orientation.top, 'S');
  EXPECT_EQ(shade(coronal, 0, 0), shade_of(7, 7, 4));
  EXPECT_EQ(shade(coronal, 7, 7), shade_of(0, 0, 4));
}

TEST(SlicePicture, PixelsAreSquare) {
  const ScratchFolder folder;
  Geometry geometry;
  geometry.spacing_mm = {0.5, 0.5, 2};
  const auto reader = built(folder, numbered_volume(geometry));
  const SlicePicture coronal = render_slice(*reader, plain(1, 0));
  EXPECT_EQ(coronal.picture.width, 8);
  EXPECT_EQ(coronal.picture.height, 32);
  EXPECT_DOUBLE_EQ(coronal.pixel_mm, 0.5);
}

TEST(SlicePicture, WindowsAreInRealUnits) {
  const ScratchFolder folder;
  const auto reader = built(folder, numbered_volume({}, {2, -100}));
  SliceOptions options = plain(2, 0);
  options.window = Window{-50, 100};
  const SlicePicture slice = render_slice(*reader, options);
  EXPECT_EQ(shade(slice, 0, 0), 0);
  EXPECT_EQ(shade(slice, 1, 3), 128);  // stored 25, real -50
  EXPECT_EQ(shade(slice, 2, 6), 255);  // stored 50, real 0
}

TEST(SlicePicture, CoarseLevelsAndDefaultsGiveAPicture) {
  const ScratchFolder folder;
  const auto reader = built(folder, numbered_volume({}));
  for (int level = 0; level < reader->levels().count(); ++level) {
    SliceOptions options;
    options.level = level;
    const SlicePicture slice = render_slice(*reader, options);
    EXPECT_EQ(slice.picture.width, 256);
    EXPECT_DOUBLE_EQ(slice.pixel_mm, 8.0 / 256);
    EXPECT_FALSE(encode_png(slice.picture).empty());
  }
}

TEST(SlicePicture, LabelsKeepTheirColors) {
  const ScratchFolder folder;
  Volume volume = numbered_volume({});
  volume.description.kind = VolumeKind::labels;
  volume.description.type = VoxelType::uint16;
  const auto reader = built(folder, volume);
  SliceOptions options = plain(2, 0);
  options.least_side = 24;
  const Picture picture = render_slice(*reader, options).picture;
  ASSERT_EQ(picture.channels, 3);
  for (std::int64_t y = 0; y < 24; ++y) {
    for (std::int64_t x = 0; x < 24; ++x) {
      const Color expected = label_color(x / 3 + 8 * (y / 3));
      EXPECT_TRUE(
          std::equal(expected.begin(), expected.end(), picture.pixels.begin() + (y * 24 + x) * 3));
    }
  }
}

TEST(SlicePicture, WhatDoesNotExistIsRefused) {
  const ScratchFolder folder;
  const auto reader = built(folder, numbered_volume({}));
  SliceOptions narrow = plain(2, 0);
  narrow.window = Window{0, 0};
  SliceOptions deep = plain(2, 0);
  deep.level = 9;
  for (const SliceOptions& options : {plain(3, 0), plain(2, 8), plain(2, -1), narrow, deep}) {
    EXPECT_THROW(render_slice(*reader, options), Error);
  }
}

}  // namespace
}  // namespace octavo
