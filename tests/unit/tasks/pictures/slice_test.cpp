#include "octavo/tasks/pictures/slice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "octavo/core/error.h"
#include "octavo/render/color_scale.h"
#include "octavo/render/label_color.h"
#include "octavo/render/slice/montage.h"
#include "support/built_file.h"
#include "support/read_png.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

constexpr Size3 kSliceSize = {40, 36, 24};

class SliceTask : public ::testing::Test {
 protected:
  void SetUp() override {
    build(scan_, VolumeKind::grey, [](double x, double y, double z) { return x + 40 * y + 7 * z; });
    build(mask_, VolumeKind::labels, [](double x, double y, double) { return x > 10 && y > 8; });
    options_.input = scan_;
    options_.output.path = folder_.file("p.png");
    context_.threads = 2;
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
  }

  template <class F>
  void build(const std::string& path, VolumeKind kind, F value, double origin_z = -30) {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = kSliceSize;
    volume.description.type = kind == VolumeKind::grey ? VoxelType::int16 : VoxelType::uint8;
    volume.description.geometry.origin_mm = {-20, -18, origin_z};
    volume.description.geometry.spacing_mm = {1, 1, 2};
    volume.description.metadata =
        Metadata::read(R"({"spacing_known":true,"place_known":true,"unit":"HU"})");
    for (std::int64_t i = 0; i < kSliceSize.voxel_count(); ++i) {
      const std::int64_t row = i / kSliceSize.x;
      const double number =
          value(static_cast<double>(i % kSliceSize.x), static_cast<double>(row % kSliceSize.y),
                static_cast<double>(row / kSliceSize.y));
      const auto stored = static_cast<std::int16_t>(number);
      const auto* bytes = reinterpret_cast<const std::byte*>(&stored);
      volume.voxels.insert(volume.voxels.end(), bytes, bytes + (kind == VolumeKind::grey ? 2 : 1));
    }
    testing::build_volume(volume, path, 1);
  }

  Picture picture(const std::string& path) const {
    const std::string bytes = testing::bytes_of_file(path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end()));
  }

  ErrorKind kind_of(const SliceOptions& options) const {
    try {
      slice(options, context_);
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::internal;
  }

  testing::ScratchFolder folder_;
  std::string scan_ = folder_.file("scan.8vo");
  std::string mask_ = folder_.file("mask.8vo");
  std::vector<std::string> warnings_;
  std::vector<Picture> pictures_;
  SliceOptions options_;
  TaskContext context_;
};

TEST_F(SliceTask, TheMiddleSliceIsDrawn) {
  const SliceResult result = slice(options_, context_);
  ASSERT_EQ(result.pictures.size(), 1u);
  const DrawnSlice& drawn = result.pictures.front();
  EXPECT_EQ(drawn.axis, 2);
  EXPECT_EQ(drawn.indices, std::vector<std::int64_t>{12});
  EXPECT_EQ(drawn.width, picture(drawn.path).width);
  EXPECT_EQ(drawn.width, 520);
  EXPECT_NEAR(drawn.pixel_mm, 40.0 / 520, 1e-12);
  ASSERT_TRUE(drawn.window);
  EXPECT_GT(drawn.window->width, 1000);
  EXPECT_EQ(picture(drawn.path).channels, 1);
  // Pixels lie where the voxels do: the middle of the picture is that of the slice.
  ASSERT_TRUE(drawn.place);
  const Point3 middle = drawn.place->at(static_cast<double>(drawn.width - 1) / 2,
                                        static_cast<double>(drawn.height - 1) / 2);
  EXPECT_NEAR(middle[0], -20 + 39 / 2.0, 1e-9);
  EXPECT_NEAR(middle[1], -18 + 35 / 2.0, 1e-9);
  EXPECT_NEAR(middle[2], -30 + 2 * 12, 1e-9);
  options_.montage = AskedMontage{2, 1, {}};
  options_.output.overwrite = true;
  EXPECT_FALSE(slice(options_, context_).pictures.front().place);
}

TEST_F(SliceTask, IsolinesOfTwoVolumesAreToldApart) {
  options_.overlays = {{scan_, {}}, {scan_, {}}};
  options_.on_picture = [&](const Picture& made) { pictures_.push_back(made); };
  slice(options_, context_);
  options_.overlays.pop_back();
  slice(options_, context_);
  ASSERT_EQ(pictures_.size(), 2u);
  const auto pixels_of = [](const Picture& one, const Color& color) {
    std::int64_t count = 0;
    for (std::size_t i = 0; i + 2 < one.pixels.size(); i += 3) {
      count += std::equal(color.begin(), color.end(), &one.pixels[i]);
    }
    return count;
  };
  EXPECT_GT(pixels_of(pictures_[0], overlay_color(1)), 100);
  EXPECT_EQ(pixels_of(pictures_[1], overlay_color(1)), 0);
}

TEST_F(SliceTask, LabelsHaveNoWindow) {
  options_.input = mask_;
  const SliceResult result = slice(options_, context_);
  EXPECT_FALSE(result.pictures.front().window);
  EXPECT_EQ(picture(options_.output.path).channels, 3);
}

TEST_F(SliceTask, SeveralAxesAreSeveralFiles) {
  options_.axes = {0, 1, 2};
  const SliceResult result = slice(options_, context_);
  ASSERT_EQ(result.pictures.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(result.pictures[i].path, folder_.file(std::string("p-") + "xyz"[i] + ".png"));
    EXPECT_GT(picture(result.pictures[i].path).width, 100);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.file("p.png")));
}

TEST_F(SliceTask, PositionsAreFoundInMm) {
  options_.position_mm = -30 + 2 * 7.2;
  EXPECT_EQ(slice(options_, context_).pictures.front().indices.front(), 7);
  options_.output.overwrite = true;
  options_.position_mm = 100;
  EXPECT_EQ(kind_of(options_), ErrorKind::invalid_argument);
}

TEST_F(SliceTask, APlaneWithoutAPointGoesThroughTheMiddle) {
  options_.plane = AskedPlane{std::nullopt, {0, 0, 1}};
  const SliceResult result = slice(options_, context_);
  const DrawnSlice& drawn = result.pictures.front();
  ASSERT_TRUE(drawn.plane);
  EXPECT_FALSE(drawn.axis);
  EXPECT_NEAR(drawn.plane->point_mm[2], -30 + 2 * 11.5, 1e-9);
  EXPECT_EQ(drawn.width, 520);
}

TEST_F(SliceTask, MontagesAreSpreadOrSpaced) {
  options_.montage = AskedMontage{3, 2, {}};
  EXPECT_EQ(slice(options_, context_).pictures.front().indices, spread_slices(24, 6));
  options_.output.overwrite = true;
  options_.montage = AskedMontage{{}, {}, 5};
  EXPECT_EQ(slice(options_, context_).pictures.front().indices,
            (std::vector<std::int64_t>{2, 7, 12, 17, 22}));
  options_.montage = AskedMontage{3, 1, 2};
  options_.index = 5;
  EXPECT_EQ(slice(options_, context_).pictures.front().indices,
            (std::vector<std::int64_t>{3, 5, 7}));
}

TEST_F(SliceTask, OverlaysAreDrawnInColor) {
  options_.has_legend = options_.has_notes = options_.has_scale_bar = options_.has_sides = false;
  options_.minimum_side = 1;
  slice(options_, context_);
  const Picture bare = picture(options_.output.path);
  options_.output.overwrite = true;
  options_.overlays = {{mask_, {}}};
  options_.overlays.front().look.kind = OverlayKind::wash;
  options_.overlays.front().look.opacity = 1;
  options_.overlays.front().look.color = Color{0, 200, 0};
  slice(options_, context_);
  const Picture covered = picture(options_.output.path);
  ASSERT_EQ(covered.channels, 3);
  for (std::int64_t y = 0; y < kSliceSize.y; ++y) {
    for (std::int64_t x = 0; x < kSliceSize.x; ++x) {
      const auto at = static_cast<std::size_t>(y * kSliceSize.x + x);
      const std::uint8_t grey = bare.pixels[at];
      const Color expected = x > 10 && y > 8 ? Color{0, 200, 0} : Color{grey, grey, grey};
      ASSERT_TRUE(std::equal(expected.begin(), expected.end(), covered.pixels.data() + 3 * at));
    }
  }
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(SliceTask, LabelsThatAreAskedForAreDrawnAlone) {
  const std::string organs = folder_.file("organs.8vo");
  build(organs, VolumeKind::labels, [](double x, double, double z) {
    return x < 10 ? 0 : x < 20 ? 4 : z < 6 ? 9 : 5;
  });
  options_.has_legend = options_.has_notes = options_.has_scale_bar = options_.has_sides = false;
  options_.minimum_side = 1;
  options_.output.overwrite = true;
  options_.labels = {{4, 9}, {}};
  const auto expect_bands = [&](bool has_ground) {
    slice(options_, context_);
    const Picture drawn = picture(options_.output.path);
    for (std::int64_t x = 0; x < kSliceSize.x; ++x) {
      const std::uint8_t* const pixel = drawn.pixels.data() + 3 * (5 * kSliceSize.x + x);
      const Color found = {pixel[0], pixel[1], pixel[2]};
      const bool is_kept = x >= 10 && x < 20;
      EXPECT_EQ(found == label_color(4), is_kept) << x;
      if (is_kept) continue;
      // Nothing is drawn, or the grey values below.
      const std::uint8_t grey = has_ground ? found[0] : std::uint8_t{0};
      EXPECT_EQ(found, (Color{grey, grey, grey})) << x;
    }
  };
  options_.input = organs;
  expect_bands(false);
  options_.input = scan_;
  options_.overlays = {{organs, {}}, {scan_, {}}};
  options_.overlays[0].look.kind = options_.overlays[1].look.kind = OverlayKind::wash;
  options_.overlays[0].look.opacity = 1;
  options_.overlays[1].look.opacity = 0;
  expect_bands(true);
  EXPECT_TRUE(warnings_.empty());
  options_.labels = {{9}, {}};
  slice(options_, context_);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("none of the labels"), std::string::npos);
  options_.overlays.clear();
  EXPECT_EQ(kind_of(options_), ErrorKind::invalid_argument);
}

TEST_F(SliceTask, AnOverlayThatLiesElsewhereIsWarnedOf) {
  const std::string elsewhere = folder_.file("far.8vo");
  build(
      elsewhere, VolumeKind::labels, [](double, double, double) { return 1; }, 500);
  options_.overlays = {{elsewhere, {}}};
  slice(options_, context_);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_.front().find("far.8vo"), std::string::npos);
}

TEST_F(SliceTask, WhatDoesNotGoTogetherIsRejectedAndWritesNothing) {
  std::vector<SliceOptions> all(15, options_);
  all[0].output.path = folder_.file("p.gif");
  all[1].axes = {};
  all[2].axes = {0, 1}, all[2].index = 3;
  all[3].index = 3, all[3].position_mm = 4;
  all[4].plane = AskedPlane{std::nullopt, {0, 0, 1}}, all[4].index = 3;
  all[5].plane = AskedPlane{std::nullopt, {0, 0, 0}};
  all[6].montage = AskedMontage{3, {}, {}};
  all[7].montage = AskedMontage{30, 30, {}};
  all[8].montage = AskedMontage{2, 2, {}}, all[8].index = 3;
  all[9].window_preset = "knee";
  all[10].input = mask_, all[10].window = Window{1, 2};
  all[11].level = 40;
  all[12].overlays = {{mask_, {}}}, all[12].overlays[0].look.kind = OverlayKind::isolines;
  all[13].axes = {0, 3};
  all[14].axes = {-1};
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(kind_of(all[i]), ErrorKind::invalid_argument) << i;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.file("p.png")));
  context_.max_memory_bytes = 10000;
  EXPECT_EQ(kind_of(options_), ErrorKind::limit_exceeded);
}

TEST_F(SliceTask, ACancelledTaskLeavesNothing) {
  testing::StoppingProgress stopping;
  context_.progress = &stopping;
  EXPECT_EQ(kind_of(options_), ErrorKind::cancelled);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("p.png")));
}

}  // namespace
}  // namespace octavo
