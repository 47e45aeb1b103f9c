#include "octavo/render/rays/ray_refine.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>

#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::noisy_ball;
using testing::ray_volume;
using testing::RayVolume;

/// A volume that is drawn with refinements.
template <class T>
class Refined {
 public:
  explicit Refined(const RayVolume<T>& volume, RayMode mode = RayMode::volume, int shift = 6,
                   std::uint64_t memory = std::uint64_t{1} << 30, double angle = 0)
      : source_(volume.samples.data(), voxel_type_of<T>(), volume.size, 32),
        bricks_(source_, {shift, memory}),
        table_({{{150, {255, 255, 255}, 0}, {400, {200, 150, 100}, 0.3}}, {}, false, {}}, {},
               bricks_.scale(), bricks_.range(), 1) {
    frame_.mode = mode;
    frame_.isovalue = 225.5f;
    frame_.bricks = bricks_.tables();
    frame_.table = table_.table();
    const View view = make_view({}, volume.size, box_of(volume.size), viewpoint_at(30, 20),
                                {kWidth, kHeight, 1, {}});
    set_camera(frame_, {view, box_of(volume.size), angle, 1, 1});
    bricks_.set_bounds([this](float lowest, float highest) {
      if (frame_.mode == RayMode::iso) return highest >= frame_.isovalue ? 1.0f : 0.0f;
      return table_.is_seen(lowest, highest) ? 1.0f : 0.0f;
    });
  }

  Picture draw(const RayRefinement& how, int threads = 2) {
    return draw_frame(frame_, kWidth, kHeight, how, threads);
  }
  Picture draw_twice_as_fine() {
    return draw_frame(frame_of_pixels(frame_, 2), 2 * kWidth, 2 * kHeight, {}, 2);
  }
  std::int64_t samples() const { return samples_; }

  // Of no whole tiles and blocks.
  static constexpr std::int64_t kWidth = 301;
  static constexpr std::int64_t kHeight = 259;

 private:
  Picture draw_frame(const RayFrame& frame, std::int64_t width, std::int64_t height,
                     const RayRefinement& how, int threads) {
    samples_ = 0;
    Picture picture;
    tbb::task_arena arena(threads);
    arena.execute([&] {
      picture = refined_picture(
          frame, width, height, how,
          [&](const RayFrame& of, std::int64_t columns, std::int64_t rows) {
            NoProgress silent;
            RayField field = cast_rays(bricks_, of, columns, rows, follow_rays_function(), silent);
            samples_ += field.samples;
            return field;
          },
          [&](const RayField&) {
            RayLook look;
            look.mode = frame.mode;
            return look;
          });
    });
    return picture;
  }

  DenseSamples source_;
  RayBricks bricks_;
  TransferTable table_;
  RayFrame frame_;
  std::int64_t samples_ = 0;
};

/// A ball of one value.
RayVolume<std::int16_t> plain_ball() {
  return ray_volume<std::int16_t>({70, 70, 70}, [](auto x, auto y, auto z) {
    const double r = std::hypot(static_cast<double>(x) - 34, static_cast<double>(y) - 30,
                                static_cast<double>(z) - 38);
    return std::clamp(300 - 40 * (r - 22), 0.0, 300.0);
  });
}

int difference_at(const Picture& a, const Picture& b, std::size_t i) {
  return std::abs(static_cast<int>(a.pixels[i]) - static_cast<int>(b.pixels[i]));
}

TEST(RayRefine, AdaptivePicturesAreNearlyTheWholeOfFewerRays) {
  const auto ball = plain_ball();
  for (const RayMode mode : {RayMode::volume, RayMode::iso}) {
    for (const double angle : {0.0, 40.0}) {
      Refined<std::int16_t> scene(ball, mode, 6, std::uint64_t{1} << 30, angle);
      const Picture whole = scene.draw({});
      const std::int64_t samples = scene.samples();
      const Picture adaptive = scene.draw({true, false});
      EXPECT_LT(scene.samples(), samples * 9 / 10) << static_cast<int>(mode);
      ASSERT_EQ(whole.pixels.size(), adaptive.pixels.size());
      std::size_t same = 0;
      std::size_t far = 0;
      for (std::size_t i = 0; i < whole.pixels.size(); ++i) {
        // What lies between the rays of a quarter may differ more than these.
        ASSERT_LE(difference_at(whole, adaptive, i), 32) << i;
        far += difference_at(whole, adaptive, i) > 20;
        same += whole.pixels[i] == adaptive.pixels[i];
      }
      EXPECT_LT(far, whole.pixels.size() / 1000);
      EXPECT_GT(same, whole.pixels.size() / 2);
    }
  }
}

TEST(RayRefine, EdgesAreMeansOfFourRaysAndTheRestIsAsItWas) {
  const auto ball = plain_ball();
  Refined<std::int16_t> scene(ball, RayMode::iso);
  const Picture plain = scene.draw({});
  const Picture smooth = scene.draw({false, true});
  const Picture fine = scene.draw_twice_as_fine();
  std::int64_t edges = 0;
  double covered = 0;
  for (std::int64_t y = 0; y < plain.height; ++y) {
    for (std::int64_t x = 0; x < plain.width; ++x) {
      const auto at = static_cast<std::size_t>(3 * (y * plain.width + x));
      covered += plain.pixels[at] != plain.pixels[0] ? 1 : 0;
      if (smooth.pixels[at] == plain.pixels[at]) continue;
      ++edges;
      int sum = 0;
      for (const std::int64_t dy : {0, 1}) {
        for (const std::int64_t dx : {0, 1}) {
          sum += fine.pixels[static_cast<std::size_t>(
              3 * ((2 * y + dy) * fine.width + 2 * x + dx))];
        }
      }
      ASSERT_EQ(smooth.pixels[at], (sum + 2) / 4) << x << ' ' << y;
    }
  }
  // A circle of radius r crosses 8 r pixels, and in half of them the square between the four rays.
  const double radius = std::sqrt(covered / std::numbers::pi);
  EXPECT_GT(static_cast<double>(edges), 3.9 * radius);
  EXPECT_LT(static_cast<double>(edges), 8.1 * radius);
}

TEST(RayRefine, BricksThreadsAndMemoryChangeNoPixel) {
  const auto ball = noisy_ball(70);
  for (const RayMode mode : {RayMode::volume, RayMode::iso}) {
    Refined<std::int16_t> first(ball, mode);
    Refined<std::int16_t> few(ball, mode, 4, 200'000);
    const Picture picture = first.draw({true, true}, 1);
    EXPECT_EQ(picture.pixels, few.draw({true, true}, 4).pixels);
    EXPECT_NE(picture.pixels, first.draw({}).pixels);
  }
}

TEST(RayRefine, OnlyWhatVariesIsCast) {
  Picture quarter = make_picture(40, 40, 3);
  EXPECT_EQ(varying_blocks(quarter, 80, 80), std::vector<std::uint64_t>(9));
  // Under pixels 0, 1: the first block, and nothing else than its neighbors.
  quarter.set(0, 0, {100, 100, 100});
  const std::vector<std::uint64_t> corner = varying_blocks(quarter, 80, 80);
  EXPECT_EQ(corner[0], 1u);
  quarter.set(0, 0, {19, 19, 19});
  EXPECT_EQ(varying_blocks(quarter, 80, 80)[0], 0u);
}

}  // namespace
}  // namespace octavo
