#include "octavo/render/slice/slice_picture.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <set>

#include "octavo/core/error.h"
#include "octavo/render/label_color.h"
#include "octavo/render/slice/montage.h"
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

std::shared_ptr<FileReader> with_slices(const ScratchFolder& folder, const Volume& volume) {
  testing::build_volume(volume, folder.file("a.8vo"), 1);
  return testing::open_file(folder.file("a.8vo"));
}

SliceCaptions nothing_written() {
  SliceCaptions captions;
  captions.has_scale_bar = captions.has_sides = captions.has_notes = captions.has_legend = false;
  return captions;
}

SlicePictureOptions plain(int axis, std::int64_t index) {
  SlicePictureOptions options;
  options.axis = axis;
  options.indices = {index};
  options.window = Window{255.5, 511};
  options.captions = nothing_written();
  options.minimum_side = 1;
  return options;
}

int shade(const SlicePicture& slice, std::int64_t x, std::int64_t y) {
  return slice.picture.pixels[static_cast<std::size_t>(y * slice.picture.width + x)];
}

int shade_of(int x, int y, int z) { return Window{255.5, 511}.grey(x + 8 * y + 64 * z); }

TEST(SlicePicture, SlicesOfAnUprightScanFollowTheConvention) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}));
  const SlicePicture axial = render_slice(*reader, plain(2, 3));
  EXPECT_EQ(shade(axial, 0, 0), shade_of(0, 0, 3));
  EXPECT_EQ(shade(axial, 7, 1), shade_of(7, 1, 3));
  EXPECT_EQ(axial.letters.left, "R");
  EXPECT_EQ(axial.letters.top, "A");
  const SlicePicture coronal = render_slice(*reader, plain(1, 2));
  EXPECT_EQ(shade(coronal, 6, 0), shade_of(6, 2, 7));
  EXPECT_EQ(coronal.letters.left, "R");
  EXPECT_EQ(coronal.letters.top, "S");
  const SlicePicture sagittal = render_slice(*reader, plain(0, 5));
  EXPECT_EQ(shade(sagittal, 1, 7), shade_of(5, 1, 0));
  EXPECT_EQ(sagittal.letters.left, "A");
  EXPECT_EQ(sagittal.letters.bottom, "I");
}

TEST(SlicePicture, FlippedAndSwappedAxesAreTurnedUpright) {
  const ScratchFolder folder;
  Geometry geometry;
  // Index x runs up, y to the right of the patient, z to the front: a coronal stack from the back.
  geometry.direction = {0, -0.999, 0.04, 0, -0.04, -0.999, 1, 0, 0};
  const auto reader = with_slices(folder, numbered_volume(geometry));
  const SlicePicture coronal = render_slice(*reader, plain(2, 4));
  EXPECT_EQ(coronal.letters.left, "R");
  EXPECT_EQ(coronal.letters.right, "L");
  EXPECT_EQ(coronal.letters.top, "S");
  EXPECT_EQ(shade(coronal, 0, 0), shade_of(7, 7, 4));
  EXPECT_EQ(shade(coronal, 7, 7), shade_of(0, 0, 4));
}

TEST(SlicePicture, PixelsAreSquare) {
  const ScratchFolder folder;
  Geometry geometry;
  geometry.spacing_mm = {0.5, 0.5, 2};
  const auto reader = with_slices(folder, numbered_volume(geometry));
  const SlicePicture coronal = render_slice(*reader, plain(1, 0));
  EXPECT_EQ(coronal.picture.width, 8);
  EXPECT_EQ(coronal.picture.height, 32);
  EXPECT_DOUBLE_EQ(coronal.pixel_mm, 0.5);
}

TEST(SlicePicture, WindowsAreInRealUnits) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}, {2, -100}));
  SlicePictureOptions options = plain(2, 0);
  options.window = Window{-50, 100};
  const SlicePicture slice = render_slice(*reader, options);
  EXPECT_EQ(shade(slice, 0, 0), 0);
  EXPECT_EQ(shade(slice, 1, 3), 128);  // stored 25, real -50
  EXPECT_EQ(shade(slice, 2, 6), 255);  // stored 50, real 0
}

TEST(SlicePicture, CoarseLevelsAndDefaultsGiveAPicture) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}));
  for (int level = 0; level < reader->levels().count(); ++level) {
    SlicePictureOptions options;
    options.level = level;
    const SlicePicture slice = render_slice(*reader, options);
    EXPECT_EQ(slice.picture.width, 512);
    EXPECT_DOUBLE_EQ(slice.pixel_mm, 8.0 / 512);
    EXPECT_FALSE(encode_png(slice.picture).empty());
  }
}

TEST(SlicePicture, LabelsKeepTheirColors) {
  const ScratchFolder folder;
  Volume volume = numbered_volume({});
  volume.description.kind = VolumeKind::labels;
  volume.description.type = VoxelType::uint16;
  const auto reader = with_slices(folder, volume);
  SlicePictureOptions options = plain(2, 0);
  options.minimum_side = 24;
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

TEST(SlicePicture, APlaneAlongTheGridIsTheSlice) {
  const ScratchFolder folder;
  Geometry geometry;
  geometry.origin_mm = {-30.1, 17, 250};
  geometry.spacing_mm = {0.7, 0.7, 2.1};
  const auto reader = with_slices(folder, numbered_volume(geometry));
  const Point3 normals[] = {{2, 0, 0}, {0, -3, 0}, {0, 0, 0.1}};
  for (int axis = 0; axis < 3; ++axis) {
    SlicePictureOptions slice = plain(axis, 5);
    slice.minimum_side = 40;
    SlicePictureOptions plane = slice;
    plane.plane = CutPlane{geometry.to_world({5, 5, 5}), normals[axis]};
    const SlicePicture expected = render_slice(*reader, slice);
    const SlicePicture found = render_slice(*reader, plane);
    EXPECT_EQ(found.letters, expected.letters);
    EXPECT_EQ(found.picture.width, expected.picture.width);
    EXPECT_EQ(found.picture.height, expected.picture.height);
    EXPECT_EQ(found.picture.pixels, expected.picture.pixels);
  }
}

TEST(SlicePicture, SlicesSideBySideAreTheSlices) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}));
  SlicePictureOptions many = plain(2, 0);
  many.indices = {1, 6, 3, 4, 7};
  many.columns = 3;
  many.minimum_side = 24;
  const SlicePicture montage = render_slice(*reader, many);
  const MontageGrid grid = montage_grid(5, 3, 8, 8);
  ASSERT_EQ(montage.picture.width, grid.width());
  ASSERT_EQ(montage.picture.height, grid.height());
  EXPECT_EQ(montage.indices, many.indices);
  std::vector<std::uint8_t> expected(montage.picture.pixels.size());
  for (std::size_t i = 0; i < many.indices.size(); ++i) {
    const SlicePicture one = render_slice(*reader, plain(2, many.indices[i]));
    const PixelArea cell = grid.cell(static_cast<std::int64_t>(i));
    for (std::int64_t y = 0; y < 8; ++y) {
      for (std::int64_t x = 0; x < 8; ++x) {
        expected[static_cast<std::size_t>((cell.y + y) * grid.width() + cell.x + x)] =
            static_cast<std::uint8_t>(shade(one, x, y));
      }
    }
  }
  EXPECT_EQ(montage.picture.pixels, expected);
}

TEST(SlicePicture, CaptionsAreWrittenWhereTheyAreAsked) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}));
  SlicePictureOptions options = plain(2, 3);
  options.minimum_side = 400;
  const auto text_of = [](const SlicePicture& slice) {
    return std::string(slice.picture.pixels.begin(), slice.picture.pixels.end());
  };
  const SlicePicture bare = render_slice(*reader, options);
  std::set<std::string> pictures = {text_of(bare)};
  const auto add = [&](auto change) {
    SlicePictureOptions changed = options;
    change(changed.captions);
    pictures.insert(text_of(render_slice(*reader, changed)));
  };
  add([](SliceCaptions& c) { c.has_scale_bar = true; });
  add([](SliceCaptions& c) { c.has_sides = true; });
  add([](SliceCaptions& c) { c.has_notes = true; });
  add([](SliceCaptions& c) { c.has_notes = true, c.is_place_known = false; });
  add([](SliceCaptions& c) { c.has_notes = true, c.is_spacing_known = false; });
  add([](SliceCaptions& c) { c.has_notes = true, c.unit = "HU"; });
  EXPECT_EQ(pictures.size(), 7u);
  // What is not known is not written.
  add([](SliceCaptions& c) { c.has_scale_bar = true, c.is_spacing_known = false; });
  add([](SliceCaptions& c) { c.has_sides = true, c.is_place_known = false; });
  EXPECT_EQ(pictures.size(), 7u);
}

TEST(SlicePicture, ThreadsDoNotChangeThePicture) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}));
  SlicePictureOptions options;
  options.plane = CutPlane{{3, 4, 3}, {1, 2, 3}};
  std::vector<std::vector<std::uint8_t>> pictures;
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena(threads).execute(
        [&] { pictures.push_back(render_slice(*reader, options).picture.pixels); });
  }
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(pictures[0], pictures[2]);
}

TEST(SlicePicture, WhatDoesNotExistIsRejected) {
  const ScratchFolder folder;
  const auto reader = with_slices(folder, numbered_volume({}));
  SlicePictureOptions narrow = plain(2, 0);
  narrow.window = Window{0, 0};
  SlicePictureOptions deep = plain(2, 0);
  deep.level = 9;
  SlicePictureOptions beside = plain(2, 0);
  beside.plane = CutPlane{{0, 0, 90}, {0, 0, 1}};
  SlicePictureOptions flat = plain(2, 0);
  flat.plane = CutPlane{{0, 0, 0}, {0, 0, 0}};
  SlicePictureOptions columns = plain(2, 0);
  columns.columns = 0;
  for (const SlicePictureOptions& options :
       {plain(3, 0), plain(2, 8), plain(2, -1), narrow, deep, beside, flat, columns}) {
    EXPECT_THROW(render_slice(*reader, options), Error);
    EXPECT_THROW(slice_pixels(*reader, options), Error);
  }
}

}  // namespace
}  // namespace octavo
