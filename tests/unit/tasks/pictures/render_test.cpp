#include "octavo/tasks/pictures/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "octavo/core/error.h"
#include "support/built_file.h"
#include "support/read_png.h"

namespace octavo {
namespace {

constexpr Size3 kRenderSize = {64, 56, 40};

/// Value of a voxel: a block of 40 with a hole of one voxel, that bears a smaller block of 90, in a
/// surrounding of 10.
std::uint8_t value_at(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto within = [](std::int64_t v, std::int64_t low, std::int64_t high) {
    return v >= low && v < high;
  };
  if (x == 20 && y == 20 && z == 15) return 10;
  if (within(x, 44, 54) && within(y, 8, 12) && within(z, 4, 8)) return 90;
  return within(x, 4, 44) && within(y, 4, 40) && within(z, 2, 34) ? 40 : 10;
}

class RenderTask : public ::testing::Test {
 protected:
  void SetUp() override {
    build(scan_, VolumeKind::grey, R"({"spacing_known":true,"place_known":true})");
    build(labels_, VolumeKind::labels,
          R"({"spacing_known":true,"place_known":true,"labels":{"40":{"name":"block"}}})");
    options_.input = scan_;
    options_.output = {folder_.file("p.png"), true};
    options_.width = 160;
    options_.height = 120;
    options_.ranges = {{{40, 100}, "", {}, {}}};
    options_.has_legend = options_.has_scale_bar = options_.has_sides = false;
    context_.threads = 2;
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
    context_.on_note = [this](const std::string& text, const std::string&) {
      notes_.push_back(text);
    };
  }

  void build(const std::string& path, VolumeKind kind, const char* metadata) {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = kRenderSize;
    volume.description.type = VoxelType::uint8;
    volume.description.geometry.origin_mm = {-20, 5, 30};
    volume.description.metadata = Metadata::read(metadata);
    for (std::int64_t i = 0; i < kRenderSize.voxel_count(); ++i) {
      const std::int64_t row = i / kRenderSize.x;
      volume.voxels.push_back(static_cast<std::byte>(
          value_at(i % kRenderSize.x, row % kRenderSize.y, row / kRenderSize.y)));
    }
    testing::build_volume(volume, path, 1);
  }

  Picture picture(const std::string& path) const {
    const std::string bytes = testing::bytes_of_file(path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end()));
  }

  std::set<Color> colors() const {
    const Picture drawn = picture(options_.output.path);
    std::set<Color> found;
    for (std::size_t i = 0; i < drawn.pixels.size(); i += 3) {
      found.insert({drawn.pixels[i], drawn.pixels[i + 1], drawn.pixels[i + 2]});
    }
    return found;
  }

  ErrorKind kind_of(const RenderOptions& options) const {
    try {
      render(options, context_);
    } catch (const Error& error) {
      return error.kind();
    }
    return ErrorKind::internal;
  }

  testing::ScratchFolder folder_;
  std::string scan_ = folder_.file("scan.8vo");
  std::string labels_ = folder_.file("labels.8vo");
  std::vector<std::string> warnings_;
  std::vector<std::string> notes_;
  RenderOptions options_;
  TaskContext context_;
};

TEST_F(RenderTask, CubesGrowPlaneByPlaneAndBoxesAreCutOut) {
  for (const RenderMode mode : {RenderMode::cubes, RenderMode::surface}) {
    options_.mode = mode;
    options_.turntable = 2;
    options_.is_growing = false;
    render(options_, context_);
    const Picture whole = picture(folder_.file("p-001.png"));
    const Picture first = picture(folder_.file("p-000.png"));
    options_.is_growing = true;
    render(options_, context_);
    EXPECT_EQ(picture(folder_.file("p-001.png")).pixels, whole.pixels);
    EXPECT_NE(picture(folder_.file("p-000.png")).pixels, first.pixels);
    options_.turntable = 0;
    options_.is_growing = false;
    const std::int64_t leaves = render(options_, context_).counts.leaves;
    AskedBox corner;
    corner.hi[0] = corner.hi[1] = 8;
    options_.removed = {corner};
    EXPECT_NE(render(options_, context_).counts.leaves, leaves);
    corner.hi[0] = 8000;
    options_.removed = {corner};
    EXPECT_EQ(kind_of(options_), ErrorKind::invalid_argument);
    options_.removed.clear();
  }
}

TEST_F(RenderTask, CubesHaveThreeShadesAndASurfaceIsSmooth) {
  options_.fade = 0;
  const RenderResult cubes = render(options_, context_);
  EXPECT_EQ(cubes.shade, RenderShade::flat);
  EXPECT_EQ(colors().size(), 4u);
  EXPECT_EQ(cubes.width, 160);
  EXPECT_GT(cubes.counts.leaves, 0);
  EXPECT_EQ(cubes.counts.drawn, cubes.counts.leaves);
  EXPECT_FALSE(cubes.counts.shell_seconds);

  options_.mode = RenderMode::surface;
  const RenderResult surface = render(options_, context_);
  EXPECT_EQ(surface.shade, RenderShade::smooth);
  EXPECT_GT(colors().size(), 20u);
  EXPECT_EQ(surface.counts.leaves, cubes.counts.leaves);
  EXPECT_LT(surface.counts.drawn, surface.counts.leaves);

  options_.shade = RenderShade::flat;
  render(options_, context_);
  EXPECT_EQ(colors().size(), 4u);
}

TEST_F(RenderTask, ASmoothSurfaceIsThatOfTheWholeMask) {
  options_.input = labels_;
  options_.mode = RenderMode::surface;
  render(options_, context_);
  const Picture surface = picture(options_.output.path);
  options_.mode = RenderMode::cubes;
  options_.shade = RenderShade::smooth;
  render(options_, context_);
  EXPECT_EQ(picture(options_.output.path).pixels, surface.pixels);
}

TEST_F(RenderTask, TheUsualViewIsFromTheLeftTheFrontAndAbove) {
  const RenderResult result = render(options_, context_);
  const double third = 1 / std::sqrt(3.0);
  EXPECT_NEAR(result.toward[0], third, 1e-12);
  EXPECT_NEAR(result.toward[1], -third, 1e-12);
  EXPECT_NEAR(result.toward[2], third, 1e-12);
  EXPECT_TRUE(notes_.empty());
  options_.view.steps = Point3{0, 0, 2};
  EXPECT_NEAR(render(options_, context_).toward[2], 1, 1e-12);
  options_.view.steps.reset();
  options_.view.azimuth_degrees = 90;
  EXPECT_NEAR(render(options_, context_).toward[0], 1, 1e-12);
}

TEST_F(RenderTask, AnUnknownPlaceIsNotedAndHasTheAxesOfTheGrid) {
  options_.has_sides = true;
  render(options_, context_);
  const Picture placed = picture(options_.output.path);
  build(scan_ + "2", VolumeKind::grey, R"({"spacing_known":true,"place_known":false})");
  std::filesystem::rename(scan_ + "2", scan_);
  render(options_, context_);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_NE(notes_.front().find("how the patient lies"), std::string::npos);
  EXPECT_NE(picture(options_.output.path).pixels, placed.pixels);
}

TEST_F(RenderTask, ATurntableHasAFileForEachPicture) {
  options_.turntable = 3;
  const RenderResult result = render(options_, context_);
  ASSERT_EQ(result.outputs.size(), 3u);
  EXPECT_EQ(result.outputs[2], folder_.file("p-002.png"));
  for (const std::string& path : result.outputs) EXPECT_EQ(picture(path).width, 160);
  EXPECT_FALSE(std::filesystem::exists(folder_.file("p.png")));
}

TEST_F(RenderTask, TransparencyTellsWhatItDrew) {
  options_.mode = RenderMode::transparency;
  options_.ranges.clear();
  const RenderResult ramp = render(options_, context_);
  ASSERT_TRUE(ramp.counts.ramp);
  EXPECT_TRUE(ramp.counts.window);
  options_.ranges = {{{40, 50}, "", Color{255, 0, 0}, 0.2}};
  options_.is_average = true;
  const RenderResult average = render(options_, context_);
  ASSERT_EQ(average.counts.ranges.size(), 1u);
  EXPECT_EQ(average.counts.ranges[0].opacity, 0.2);
  EXPECT_FALSE(average.counts.window);
  EXPECT_FALSE(average.counts.ramp);
}

TEST_F(RenderTask, CutsLeaveLessAndNothingIsWarnedOf) {
  const std::int64_t leaves = render(options_, context_).counts.leaves;
  options_.cuts = {{0, true, 14}};
  EXPECT_LT(render(options_, context_).counts.leaves, leaves);
  options_.cuts = {{1, false, 45}};
  EXPECT_EQ(render(options_, context_).counts.leaves, 0);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_.front().find("empty"), std::string::npos);
}

TEST_F(RenderTask, LabelsHaveALegendWithTheirNames) {
  options_.input = labels_;
  options_.ranges.clear();
  options_.width = options_.height = 400;
  const RenderResult result = render(options_, context_);
  EXPECT_EQ(result.counts.masks, 3);
  const Picture bare = picture(options_.output.path);
  options_.has_legend = true;
  render(options_, context_);
  const Picture written = picture(options_.output.path);
  std::int64_t changed = 0;
  for (std::int64_t i = 0; i < 3 * 400 * 200; ++i) {
    changed +=
        written.pixels[static_cast<std::size_t>(i)] != bare.pixels[static_cast<std::size_t>(i)];
  }
  EXPECT_GT(changed, 500);
}

TEST_F(RenderTask, LabelsThatAreAskedForAreDrawnAlone) {
  options_.input = labels_;
  options_.shade = RenderShade::flat;
  options_.fade = 0;
  const auto drawn = [&](const AskedLabels& labels, const std::vector<AskedLook>& ranges) {
    options_.labels = labels;
    options_.ranges = ranges;
    const std::int64_t masks = render(options_, context_).counts.masks;
    return std::pair(masks, colors());
  };
  EXPECT_EQ(drawn({{}, {"block"}}, {}), drawn({}, {{{40, 40}, "", {}, {}}}));
  EXPECT_EQ(drawn({{90, 40}, {}}, {}), drawn({}, {{{40, 90}, "", {}, {}}}));
  EXPECT_EQ(drawn({{90}, {}}, {{{40, 40}, "", {}, {}}}).first, 2);
  EXPECT_TRUE(warnings_.empty());
  EXPECT_EQ(drawn({{90, 41}, {}}, {}).first, 1);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_[0].find("no voxel has label 41"), std::string::npos);
}

TEST_F(RenderTask, WhatDoesNotGoTogetherIsRejectedAndWritesNothing) {
  std::vector<RenderOptions> all(20, options_);
  all[0].output.path = folder_.file("p.gif");
  all[1].ranges.clear();
  all[2].tissues = {"knee"};
  all[3].level = 77;
  all[4].width = 0;
  all[5].zoom = -1;
  all[6].view.side = "up";
  all[7].view.steps = Point3{0, 0, 0};
  all[8].cuts = {{0, true, 64}};
  all[9].cuts = {{0, true, 4}, {0, false, 9}};
  all[10].is_average = true;
  all[11].window = Window{1, 2};
  all[12].ranges[0].opacity = 0.5;
  for (std::size_t i = 13; i < 17; ++i) all[i].mode = RenderMode::transparency;
  all[13].fade = 0.2;
  all[14].shade = RenderShade::flat;
  all[15].turntable = 9;
  all[16].input = labels_;
  all[17].labels = {{40}, {}};
  all[18].input = labels_, all[18].labels = {{}, {"Block"}};
  all[19].turntable = -1;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(kind_of(all[i]), ErrorKind::invalid_argument) << i;
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.file("p.png")));
  context_.max_memory_bytes = 1000;
  EXPECT_EQ(kind_of(options_), ErrorKind::limit_exceeded);
}

TEST_F(RenderTask, WhatSmoothShadesTakeCountsAgainstTheLimit) {
  context_.max_memory_bytes = 2 << 20;
  options_.shade = RenderShade::flat;
  EXPECT_NO_THROW(render(options_, context_));
  options_.shade = RenderShade::smooth;
  EXPECT_EQ(kind_of(options_), ErrorKind::limit_exceeded);
  context_.max_memory_bytes = 8 << 20;
  EXPECT_NO_THROW(render(options_, context_));
}

}  // namespace
}  // namespace octavo
