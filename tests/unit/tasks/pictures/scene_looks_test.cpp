#include "octavo/tasks/pictures/scene_looks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "octavo/core/error.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/inputs.h"
#include "support/built_file.h"
#include "support/read_png.h"

namespace octavo {
namespace {

constexpr Size3 kSize = {150, 130, 140};

class LooksBesideGrey : public ::testing::Test {
 protected:
  void SetUp() override {
    build("grey.8vo", VolumeKind::grey, kSize, "{}", [](const Index3& at) {
      return at.x < 75 ? 200 + at.x % 3 : 100;
    });
    build("labels.8vo", VolumeKind::labels, kSize,
          R"({"labels":{"1":{"name":"liver","color":"#c81e1e"},"3":{"name":"spleen"}}})",
          [](const Index3& at) { return at.z < 40 ? 0 : at.z < 100 ? 1 : 3; });
    options_.input = folder_.file("grey.8vo");
    options_.label_map = folder_.file("labels.8vo");
    options_.mode = RenderMode::volume;
    options_.output = {folder_.file("p.png"), true};
    options_.width = options_.height = 90;
    options_.view.side = "front";
    options_.has_legend = options_.has_scale_bar = options_.has_sides = false;
    context_.threads = 2;
    context_.on_warning = [this](const Warning& warning) { warnings_.push_back(warning.text); };
  }

  template <class F>
  void build(const std::string& name, VolumeKind kind, const Size3& size, const std::string& meta,
             F&& value_of) {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = size;
    volume.description.type = VoxelType::uint8;
    volume.description.metadata = Metadata::read(meta);
    visit_cells(box_of(size), {1, 1, 1}, [&](const Index3& at) {
      volume.voxels.push_back(static_cast<std::byte>(value_of(at)));
      return true;
    });
    testing::build_volume(volume, folder_.file(name), 1);
  }

  Picture draw() {
    result_ = render(options_, context_);
    const std::string bytes = testing::bytes_of_file(options_.output.path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end()));
  }

  static Color at(const Picture& picture, std::int64_t x, std::int64_t y) {
    const std::uint8_t* const p = picture.pixels.data() + 3 * (y * picture.width + x);
    return {p[0], p[1], p[2]};
  }

  std::unique_ptr<SceneLooks> looks() {
    const auto reader = open_volume(options_.input, context_);
    return std::make_unique<SceneLooks>(options_, *reader, 0, context_);
  }

  testing::ScratchFolder folder_;
  RenderOptions options_;
  RenderResult result_;
  TaskContext context_;
  std::vector<std::string> warnings_;
};

TEST_F(LooksBesideGrey, LabelsAreSeenInTheirColorsAndNamedByVoxels) {
  const auto looks = this->looks();
  const std::vector<LegendRow> rows = looks->legend();
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].text, "liver");
  EXPECT_EQ(rows[0].color, (Color{200, 30, 30}));
  EXPECT_EQ(rows[1].text, "spleen");
  const Picture picture = draw();
  const Color liver = at(picture, 30, 50);
  EXPECT_GT(liver[0], liver[1] + 60);
  EXPECT_NEAR(liver[1], liver[2], 1);
}

TEST_F(LooksBesideGrey, OneIsChosenOneIsHiddenAndOneIsATransferFunction) {
  const auto spread = [&](std::int64_t y) {
    const Color color = at(draw(), 30, y);
    return static_cast<int>(color[0]) - static_cast<int>(color[2]);
  };
  options_.labels.names = {"liver"};
  AskedLabelLook others;
  others.is_hidden = true;
  options_.label_looks = {others};
  EXPECT_GT(spread(50), 60);
  EXPECT_EQ(at(draw(), 30, 15), (Color{0, 0, 0}));  // spleen, above
  EXPECT_EQ(at(draw(), 30, 80), (Color{0, 0, 0}));  // label 0, below
  AskedLabelLook plain;
  plain.labels.numbers = {3};
  plain.color = Color{0, 0, 255};
  plain.opacity = 0.9;
  options_.label_looks.push_back(plain);
  EXPECT_LT(spread(15), -60);
  AskedLabelLook of_values;
  of_values.labels.numbers = {3};
  of_values.transfer = "mr";
  options_.label_looks.back() = of_values;
  EXPECT_GT(spread(15), 10);
  AskedLabelLook nothing_there;
  nothing_there.labels.numbers = {9};
  options_.label_looks.push_back(nothing_there);
  draw();
  ASSERT_FALSE(warnings_.empty());
  EXPECT_NE(warnings_.back().find("label 9"), std::string::npos);
  // Between labels that are there; each is warned of once, whatever else reads the label map.
  warnings_.clear();
  options_.label_looks.back().labels.numbers = {1, 2};
  options_.has_shadows = true;
  draw();
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_.back().find("no voxel has label 2"), std::string::npos);
  options_.has_shadows = false;
}

TEST_F(LooksBesideGrey, AMaskHidesWhatIsNotInItInEveryMode) {
  options_.mask = options_.label_map;
  options_.label_map.clear();
  options_.isovalue.reset();
  for (const RenderMode mode : {RenderMode::volume, RenderMode::mip, RenderMode::minip,
                                RenderMode::mean, RenderMode::iso}) {
    options_.mode = mode;
    if (mode == RenderMode::iso) options_.isovalue = 50;
    if (mode == RenderMode::volume || mode == RenderMode::iso) options_.window.reset();
    else options_.window = Window{100, 200};
    const Picture picture = draw();
    EXPECT_EQ(at(picture, 30, 80), (Color{0, 0, 0})) << static_cast<int>(mode);
    EXPECT_NE(at(picture, 30, 50), (Color{0, 0, 0})) << static_cast<int>(mode);
  }
  // The bricks of planes that no mask reaches are not decoded.
  build("top.8vo", VolumeKind::labels, kSize, "{}",
        [](const Index3& p) { return p.z > 132 ? 1 : 0; });
  options_.mode = RenderMode::mean;
  options_.isovalue.reset();
  draw();
  const std::int64_t all = result_.counts.decoded_bricks;
  options_.mask = folder_.file("top.8vo");
  draw();
  EXPECT_LT(result_.counts.decoded_bricks, all);
}

TEST_F(LooksBesideGrey, CoarseLevelsShadesThreadsAndMemoryGoWithThem) {
  options_.has_ambient_shade = options_.has_shadows = true;
  for (const int level : {0, 2}) {
    options_.level = level;
    context_.threads = 1;
    context_.max_memory_bytes = 0;
    const Picture picture = draw();
    EXPECT_GT(at(picture, 30, 50)[0], at(picture, 30, 50)[1] + 30);
    context_.threads = 3;
    context_.max_memory_bytes =
        2 * (decoding_bytes(open_volume(options_.input, context_)->description(), context_) +
             (12 << 20));
    EXPECT_EQ(draw().pixels, picture.pixels);
  }
}

TEST_F(LooksBesideGrey, WhatDoesNotFitIsRejected) {
  const auto expect_rejected = [&](const char* text) {
    try {
      draw();
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
    }
  };
  const RenderOptions sound = options_;
  options_.label_map = options_.input;
  expect_rejected("not labels");
  options_ = sound;
  options_.mask = options_.input;
  expect_rejected("not a mask");
  options_ = sound;
  build("small.8vo", VolumeKind::labels, {20, 20, 20}, "{}", [](const Index3&) { return 1; });
  options_.mask = folder_.file("small.8vo");
  expect_rejected("20 x 20 x 20");
  options_ = sound;
  options_.label_looks.emplace_back().labels.names = {"kidney"};
  expect_rejected("kidney");
  options_ = sound;
  options_.mode = RenderMode::mip;
  expect_rejected("volume and iso");
  options_ = sound;
  options_.label_map.clear();
  options_.label_looks.emplace_back();
  expect_rejected("label map");
  options_ = sound;
  for (int i = 0; i < 40; ++i) {
    AskedLabelLook look;
    look.labels.numbers = {i % 3 + 1};
    look.opacity = i / 50.0;
    options_.label_looks.push_back(look);
  }
  EXPECT_NO_THROW(draw());  // of each label the last one counts
}

}  // namespace
}  // namespace octavo
