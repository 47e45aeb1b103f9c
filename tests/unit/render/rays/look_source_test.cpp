#include "octavo/render/rays/look_source.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::CastScene;
using testing::cast_scene;
using testing::expect_levels_alike;
using testing::gathered;
using testing::noisy_ball;
using testing::ray_volume;
using testing::RaySetup;

/// Looks in memory.
class DenseLooks final : public LookSource {
 public:
  template <class F>
  DenseLooks(const Size3& size, std::vector<LookSet> sets, F&& look_of)
      : size_(size), sets_(std::move(sets)) {
    visit_cells(box_of(size), {1, 1, 1}, [&](const Index3& at) {
      looks_.push_back(static_cast<std::uint16_t>(look_of(at)));
      return true;
    });
    for (const LookSet set : sets_) {
      int function = -1;
      while (set != 0 && (function < 0 || (set >> function & 1) == 0)) ++function;
      begins_.push_back(function < 0 ? -1
                                     : TransferTable::begin_of(static_cast<std::size_t>(function)));
    }
    colors_.resize(sets_.size());
  }

  std::span<const LookSet> sets() const override { return sets_; }
  LookSet within(const Box& box) const override {
    LookSet all = 0;
    visit_cells(box, {1, 1, 1}, [&](const Index3& at) {
      all |= sets_[at_place(at)];
      return true;
    });
    return all;
  }
  void read(const Box& box, std::uint16_t* out) const override {
    visit_cells(box, {1, 1, 1}, [&](const Index3& at) {
      *out++ = at_place(at);
      return true;
    });
  }
  LookTable table() const { return {begins_.data(), colors_.data()}; }
  std::uint16_t at_place(const Index3& at) const {
    return looks_[static_cast<std::size_t>((at.z * size_.y + at.y) * size_.x + at.x)];
  }

  std::vector<std::uint32_t> colors_;

 private:
  Size3 size_;
  std::vector<LookSet> sets_;
  std::vector<std::int32_t> begins_;
  std::vector<std::uint16_t> looks_;
};

constexpr RayMode kModes[] = {RayMode::volume, RayMode::extreme, RayMode::mean, RayMode::iso};

/// Islands of three looks: hidden, that of the picture, and one of their own.
DenseLooks islands(std::int64_t side) {
  return DenseLooks({side, side, side}, {0, 1, 2}, [](const Index3& at) {
    return (at.x / 9 * 5 + at.y / 7 * 3 + at.z / 11 + at.x * at.y % 5 / 4) % 3;
  });
}

TEST(LookSource, WhatLooksHideIsNotSeen) {
  // Half of a cube.
  const auto cube = ray_volume<std::uint8_t>({40, 40, 40}, [](auto x, auto y, auto) {
    return y < 20 ? 100 + x : 50;
  });
  const DenseLooks half({40, 40, 40}, {0, 1}, [](const Index3& at) { return at.y < 20 ? 0 : 1; });
  RaySetup setup;
  setup.viewpoint = *find_viewpoint("front");
  setup.looks = &half;
  setup.look_table = half.table();
  setup.transfer = {{{50, {255, 255, 255}, 0.05}}, {}, false};
  const auto middle = [&](const CastScene& scene, bool is_red) {
    double found = 0;
    scene.field.for_each_pixel([&](auto x, auto y, const RayTile& tile, std::size_t i) {
      if (x == 48 && y == 40) found = is_red ? tile.red[i] : tile.gathered[i];
    });
    return found;
  };
  // The step across the face belongs to the voxel that is nearest to its middle.
  EXPECT_NEAR(middle(cast_scene(cube, setup), false), 1 - std::pow(0.95, 20.5), 1 / 255.0);
  setup.mode = RayMode::extreme;
  EXPECT_EQ(middle(cast_scene(cube, setup), false), 50);
  setup.mode = RayMode::mean;
  const CastScene mean = cast_scene(cube, setup);
  EXPECT_NEAR(middle(mean, false), 20, 0.51);
  EXPECT_NEAR(middle(mean, true) / middle(mean, false), 50, 2);
  // The surface is the face of what is seen.
  setup.mode = RayMode::iso;
  setup.isovalue = 40;
  const double k = [&] {
    double found = 0;
    cast_scene(cube, setup).field.for_each_pixel(
        [&](auto x, auto y, const RayTile& tile, std::size_t i) {
          if (x == 48 && y == 40) found = tile.blue[i];
        });
    return found;
  }();
  // The image plane lies half a step before the cube, whose face is half a voxel before sample 0.
  EXPECT_NEAR(k, 0.5 + 0.5 + 19.5, 1e-2);
}

TEST(LookSource, AnIsosurfaceHasTheLooksOfItsInside) {
  // Labels of what is at or above the isovalue, as a threshold makes them.
  auto ball = noisy_ball(40);
  const DenseLooks inside({40, 40, 40}, {1, 1},
                          [&](const Index3& at) { return ball.at(at) >= 226 ? 1 : 0; });
  for (const float sign : {1.0f, -1.0f}) {
    for (const double angle : {0.0, 40.0}) {
      for (const bool is_cut : {false, true}) {
        RaySetup setup;
        if (is_cut) setup.follow = follow_rays_portable;
        setup.mode = RayMode::iso;
        setup.sign = sign;
        setup.isovalue = 225.5 * sign;
        setup.angle_degrees = angle;
        setup.looks = &inside;
        setup.look_table = inside.table();
        if (is_cut) setup.shown = Box{{0, 0, 0}, {40, 21, 40}};
        int hits = 0;
        const CastScene scene = cast_scene(ball, setup);
        scene.field.for_each_pixel([&](auto x, auto y, const RayTile& tile, std::size_t i) {
          if (tile.gathered[i] == 0) return;
          ++hits;
          EXPECT_EQ(tile.gathered[i], 2) << x << " " << y << " " << sign << " " << angle;
        });
        EXPECT_GT(hits, 500);
      }
    }
    for (std::int16_t& sample : ball.samples) sample = static_cast<std::int16_t>(-sample);
  }
}

TEST(LookSource, LabelsHaveFunctionsAndColorsOfTheirOwn) {
  const auto cube = ray_volume<std::uint8_t>({40, 40, 40}, [](auto, auto, auto) { return 100; });
  DenseLooks halves({40, 40, 40}, {0, 1, 2},
                    [](const Index3& at) { return at.x < 20 ? 1 : 2; });
  halves.colors_[2] = 0xff0000ff;  // red
  RaySetup setup;
  setup.viewpoint = *find_viewpoint("front");
  setup.looks = &halves;
  setup.look_table = halves.table();
  setup.transfer = {{{100, {0, 0, 255}, 0.02}}, {}, false};
  setup.look_functions = {{{{0, {0, 255, 0}, 0.05}}, {}, false}};
  const CastScene scene = cast_scene(cube, setup);
  scene.field.for_each_pixel([&](auto x, auto y, const RayTile& tile, std::size_t i) {
    // x runs to the patient's left: to the right of the picture.
    const double column = (static_cast<double>(x) + 0.5 - 48) * scene.view.pixel_mm;
    if (std::abs(column) > 18 || std::abs(column) < 1 || y != 40) return;
    const double opacity = 1 - std::pow(column < 0 ? 0.98 : 0.95, 40);
    EXPECT_NEAR(tile.gathered[i], opacity, 1 / 255.0) << x;
    EXPECT_NEAR(column < 0 ? tile.blue[i] : tile.red[i], kFlatLight * opacity, 1 / 255.0) << x;
    EXPECT_EQ(tile.green[i], 0);
  });
}

TEST(LookSource, WhatIsSkippedBricksMemoryAndInstructionSetsChangeNoBit) {
  const auto ball = noisy_ball(70);
  DenseLooks looks = islands(70);
  looks.colors_[2] = 0xff20c040;
  for (const RayMode mode : kModes) {
    for (const double angle : {0.0, 50.0}) {
      RaySetup setup;
      setup.mode = mode;
      setup.angle_degrees = angle;
      setup.looks = &looks;
      setup.look_table = looks.table();
      setup.look_functions = {{{{250, {255, 0, 0}, 0}, {330, {255, 0, 0}, 0.4}}, {}, false}};
      const CastScene first = cast_scene(ball, setup);
      setup.skips = false;
      const CastScene taking = cast_scene(ball, setup);
      EXPECT_EQ(gathered(first.field), gathered(taking.field)) << static_cast<int>(mode);
      setup.skips = true;
      setup.threads = 4;
      setup.brick_shift = 4;
      setup.memory_bytes = 400'000;
      const CastScene few = cast_scene(ball, setup);
      EXPECT_EQ(gathered(first.field), gathered(few.field)) << static_cast<int>(mode);
      expect_levels_alike(ball, setup, few);
    }
  }
}

TEST(LookSource, BricksWithoutAnythingSeenAreNotLoaded) {
  const auto ball = noisy_ball(96);
  const DenseLooks corner({96, 96, 96}, {0, 1},
                          [](const Index3& at) { return at.x + at.y + at.z < 90 ? 1 : 0; });
  RaySetup setup;
  setup.brick_shift = 5;
  const CastScene all = cast_scene(ball, setup);
  setup.looks = &corner;
  setup.look_table = corner.table();
  const CastScene seen = cast_scene(ball, setup);
  EXPECT_LT(seen.loaded, all.loaded);
  EXPECT_LT(2 * seen.field.samples, all.field.samples);
}

}  // namespace
}  // namespace octavo
