#include "octavo/tasks/pictures/rank_rays.h"

#include <gtest/gtest.h>

#include <cmath>

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
    testing::Volume volume;
    volume.description.size = kSize;
    volume.description.type = VoxelType::uint8;
    volume.description.metadata = Metadata::read(R"({"spacing_known":true,"place_known":true})");
    visit_cells(box_of(kSize), {1, 1, 1}, [&](const Index3& at) {
      const double r = std::hypot(static_cast<double>(at.x) - 70, static_cast<double>(at.y) - 60,
                                  static_cast<double>(at.z) - 75);
      const auto noise = static_cast<double>((at.x * 73 + at.y * 151 + at.z * 283) % 17);
      volume.voxels.push_back(
          static_cast<std::byte>(r > 64 ? 0 : 100 + 80 * std::cos(r / 4) + noise));
      return true;
    });
    testing::build_volume(volume, folder_.file("fog.8vo"), 1);
    options_.input = folder_.file("fog.8vo");
    options_.width = 140;
    options_.height = 120;
    context_.threads = 1;
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
        ASSERT_NEAR(parts.pixels[i], whole.pixels[i], 1) << static_cast<int>(mode) << ' ' << i;
      }
      EXPECT_GE(result.counts.rays.samples, one.counts.rays.samples);
      EXPECT_GE(result.counts.decoded_bricks, one.counts.decoded_bricks);
    }
  }
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
  options_.marks = {{{1, 2, 3}, "here", std::nullopt}};
  expect_rejected(options_);
}

}  // namespace
}  // namespace octavo
