#include "octavo/tasks/pictures/rank_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/dist/thread_ranks.h"
#include "octavo/tasks/pictures/render.h"
#include "support/built_file.h"
#include "support/read_png.h"

namespace octavo {
namespace {

class RankRays : public ::testing::Test {
 protected:
  static constexpr Size3 kSize = {150, 130, 140};

  /// Rings of fog around a hard middle, with noise.
  void SetUp() override {
    build("fog.8vo", VolumeKind::grey, [](const Index3& at) {
      const double r = std::hypot(static_cast<double>(at.x) - 70, static_cast<double>(at.y) - 60,
                                  static_cast<double>(at.z) - 75);
      const auto noise = static_cast<double>((at.x * 73 + at.y * 151 + at.z * 283) % 17);
      return static_cast<int>(r > 64 ? 0 : 100 + 80 * std::cos(r / 4) + noise);
    });
    options_.input = folder_.file("fog.8vo");
    options_.width = 140;
    options_.height = 120;
    context_.threads = 1;
  }

  template <class F>
  void build(const std::string& name, VolumeKind kind, F&& value_of) {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = kSize;
    volume.description.type = VoxelType::uint8;
    volume.description.metadata = Metadata::read(R"({"spacing_known":true,"place_known":true})");
    visit_cells(box_of(kSize), {1, 1, 1}, [&](const Index3& at) {
      volume.voxels.push_back(static_cast<std::byte>(value_of(at)));
      return true;
    });
    testing::build_volume(volume, folder_.file(name), 1);
  }

  void expect_as_on_one_machine() {
    options_.output = {folder_.file("one.png"), true};
    const RenderResult one = render(options_, context_);
    const Picture whole = picture(options_.output.path);
    for (const int count : {1, 2, 5}) {
      options_.output = {folder_.file("ranks.png"), true};
      RenderResult result;
      run_thread_ranks(count, [&](Communicator& ranks) {
        const RenderResult of_rank = render_by_ranks(options_, ranks, context_);
        if (ranks.is_first()) result = of_rank;
      });
      const Picture parts = picture(options_.output.path);
      ASSERT_EQ(parts.pixels.size(), whole.pixels.size());
      for (std::size_t i = 0; i < parts.pixels.size(); ++i) {
        ASSERT_NEAR(parts.pixels[i], whole.pixels[i], 1)
            << static_cast<int>(options_.mode) << ' ' << i;
      }
      // How many rays that go together take besides depends on where nodes end.
      EXPECT_GT(10 * result.counts.rays.samples, 9 * one.counts.rays.samples);
      EXPECT_GE(result.counts.decoded_bricks, one.counts.decoded_bricks);
    }
  }

  Picture picture(const std::string& path) const {
    const std::string bytes = testing::bytes_of_file(path);
    return testing::read_png(Bytes(bytes.begin(), bytes.end()));
  }

  testing::ScratchFolder folder_;
  RenderOptions options_;
  TaskContext context_;
};

TEST_F(RankRays, PicturesAreThoseOfOneMachine) {
  options_.removed.resize(1);
  options_.removed[0].lo = {70, 60, 75};
  for (const RenderMode mode : {RenderMode::volume, RenderMode::mip, RenderMode::minip,
                                RenderMode::mean, RenderMode::iso}) {
    options_.mode = mode;
    options_.isovalue.reset();
    if (mode == RenderMode::iso) options_.isovalue = 150;
    options_.angle_degrees.reset();
    if (mode != RenderMode::mean) options_.angle_degrees = 40;
    expect_as_on_one_machine();
  }
}

TEST_F(RankRays, MasksAndLabelsAreSeenAsOnOneMachine) {
  build("slab.8vo", VolumeKind::labels, [](const Index3& at) {
    return at.x + at.y > 90 && at.z < 110 ? 1 : 0;
  });
  build("parts.8vo", VolumeKind::labels, [](const Index3& at) {
    return 1 + (at.x / 50 + at.y / 40) % 3;
  });
  options_.mode = RenderMode::volume;
  options_.mask = folder_.file("slab.8vo");
  expect_as_on_one_machine();
  options_.label_map = folder_.file("parts.8vo");
  expect_as_on_one_machine();
  options_.mode = RenderMode::iso;
  options_.isovalue = 150;
  expect_as_on_one_machine();
}

TEST_F(RankRays, MeshesAndMarksAreInOrderAsOnOneMachine) {
  // Bars through all of it and far out, across the faces of nodes and along them; sheets at faces.
  const auto write_mesh = [&](const std::string& name, const std::string& rows) {
    std::ofstream(folder_.file(name)) << rows;
    return folder_.file(name);
  };
  const std::string bar = write_mesh("bar.obj",
                                     "v -60 20 30\nv 210 90 110\nv 210 96 110\nv -60 26 30\n"
                                     "f 1 2 3\nf 1 3 4\n");
  const std::string sheet = write_mesh("sheet.obj",
                                       "v 63.6 -20 -20\nv 64.2 160 -20\nv 64.2 160 170\n"
                                       "v 63.6 -20 170\nf 1 2 3\nf 1 3 4\n"
                                       "v -20 63.8 -20\nv 170 63.8 -20\nv 170 64.3 170\n"
                                       "v -20 64.3 170\nf 5 6 7\nf 5 7 8\n");
  options_.meshes = {{bar, Color{220, 40, 30}, 1}, {sheet, Color{40, 90, 220}, 0.4}};
  options_.marks = {{{70, 60, 138}, "top", std::nullopt}};
  options_.removed.resize(1);
  options_.removed[0].lo = {90, 60, 75};
  for (const RenderMode mode : {RenderMode::volume, RenderMode::mip, RenderMode::mean,
                                RenderMode::iso}) {
    options_.mode = mode;
    options_.isovalue.reset();
    if (mode == RenderMode::iso) options_.isovalue = 150;
    expect_as_on_one_machine();
    options_.angle_degrees = 50;
    options_.view.azimuth_degrees = 215;
    expect_as_on_one_machine();
  }
}

TEST_F(RankRays, MeshesThatRaysMeetDozensOfTimesTakeNoLightFromWhatLiesBehind) {
  std::ofstream sheets(folder_.file("sheets.obj"));
  for (int i = 0; i < 160; ++i) {
    const double y = 10 + 0.31 * i;
    for (const auto& [x, z] : {std::pair{-20, -20}, {170, -20}, {170, 170}, {-20, 170}}) {
      sheets << "v " << x << ' ' << y + 0.002 * x << ' ' << z << '\n';
    }
    sheets << "f " << 4 * i + 1 << ' ' << 4 * i + 2 << ' ' << 4 * i + 3 << ' ' << 4 * i + 4 << '\n';
  }
  sheets.close();
  options_.meshes = {{folder_.file("sheets.obj"), Color{200, 200, 200}, 0.01}};
  options_.mode = RenderMode::volume;
  options_.view.azimuth_degrees = 10;
  expect_as_on_one_machine();
}

TEST_F(RankRays, OptionsThatRanksDoNotHaveAreRejected) {
  const auto expect_rejected = [&](const RenderOptions& options) {
    run_thread_ranks(1, [&](Communicator& ranks) {
      EXPECT_THROW(render_by_ranks(options, ranks, context_), Error);
    });
  };
  options_.output = {folder_.file("p.png"), true};
  options_.mode = RenderMode::cubes;
  expect_rejected(options_);
  options_.mode = RenderMode::volume;
  options_.is_adaptive = true;
  expect_rejected(options_);
}

}  // namespace
}  // namespace octavo
