#include "octavo/render/rays/ray_regions.h"

#include <gtest/gtest.h>

#include <random>

#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::CastScene;
using testing::cast_scene;
using testing::expect_levels_alike;
using testing::noisy_ball;
using testing::RaySetup;
using testing::RayVolume;

Box random_box(std::mt19937& random, std::int64_t side) {
  std::uniform_int_distribution<std::int64_t> place(0, side);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t a = place(random);
    const std::int64_t b = place(random);
    box.lo[axis] = std::min(a, b);
    box.hi[axis] = std::max(a, b);
  }
  return box;
}

TEST(RayRegions, WhatIsLeftOfABoxIsEveryVoxelOnce) {
  std::mt19937 random(7);
  for (int round = 0; round < 40; ++round) {
    const Box whole{{1, 2, 0}, {9, 8, 10}};
    const std::vector<Box> removed = {random_box(random, 10), random_box(random, 10),
                                      random_box(random, 10)};
    const std::vector<Box> left = without_boxes(whole, removed);
    visit_cells({{0, 0, 0}, {11, 11, 11}}, {1, 1, 1}, [&](const Index3& voxel) {
      const bool is_left = whole.contains(voxel) &&
                           std::none_of(removed.begin(), removed.end(),
                                        [&](const Box& box) { return box.contains(voxel); });
      EXPECT_EQ(std::count_if(left.begin(), left.end(),
                              [&](const Box& box) { return box.contains(voxel); }),
                is_left ? 1 : 0);
      return true;
    });
  }
}

TEST(RayRegions, VoxelsOfLevel0EndBetweenSamplesOfOthers) {
  // The last sample of level 2 stands for one voxel along x, for two along y; z is halved once.
  const Levels levels({41, 30, 8}, {3, 7, 7, 7, 7, 3});
  const RayRegion all = region_at_level(box_of(levels.size(0)), levels, 2);
  EXPECT_EQ(all.low, (std::array<float, 3>{-0.5f, -0.5f, -0.5f}));
  EXPECT_EQ(all.high, (std::array<float, 3>{9.75f, 7, 3.5f}));
  const RayRegion inner = region_at_level({{6, 8, 1}, {41, 30, 3}}, levels, 2);
  EXPECT_EQ(inner.low, (std::array<float, 3>{1, 1.5f, 0}));
  const RayRegion part = region_within(region_of({{0, 0, 0}, {11, 4, 4}}), inner);
  EXPECT_EQ(part.low, inner.low);
  EXPECT_EQ(part.high, (std::array<float, 3>{9.75f, 3.5f, 1}));
  EXPECT_EQ(part.whole_high, part.high);
  EXPECT_EQ(region_at_level({{2, 3, 4}, {9, 9, 9}}, levels, 0), region_of({{2, 3, 4}, {9, 9, 9}}));
}

TEST(RayRegions, EmptyBoxesTakeNothingAway) {
  const Size3 size = {10, 9, 8};
  const std::vector<Box> removed = {{{3, 0, 0}, {3, 9, 8}}, {{2, 4, 4}, {5, 4, 6}}};
  EXPECT_EQ(KeptVoxels(box_of(size), removed, size).cuts(), nullptr);
  const std::vector<Box> with_one = {removed[0], {{1, 2, 3}, {4, 5, 6}}, removed[1]};
  const KeptVoxels kept(box_of(size), with_one, size);
  ASSERT_NE(kept.cuts(), nullptr);
  ASSERT_EQ(kept.cuts()->hole_count, 1U);
  EXPECT_EQ(kept.cuts()->holes[0].before, (std::array<float, 3>{0, 1, 2}));
  EXPECT_EQ(kept.cuts()->holes[0].behind, (std::array<float, 3>{4, 5, 6}));
}

/// Noise with one value wherever it is cut away.
RayVolume<std::int16_t> filled_noise(const RaySetup& setup, std::int16_t value) {
  auto volume = noisy_ball(24);
  visit_cells(box_of(volume.size), {1, 1, 1}, [&](const Index3& voxel) {
    const bool is_left = setup.shown->contains(voxel) &&
                         std::none_of(setup.removed.begin(), setup.removed.end(),
                                      [&](const Box& box) { return box.contains(voxel); });
    auto& sample =
        volume.samples[static_cast<std::size_t>((voxel.z * 24 + voxel.y) * 24 + voxel.x)];
    if (!is_left) sample = value;
    return true;
  });
  // The range of all is the same, whatever the value.
  volume.samples[static_cast<std::size_t>((12 * 24 + 12) * 24 + 12)] = -200;
  volume.samples[static_cast<std::size_t>((12 * 24 + 12) * 24 + 13)] = 900;
  return volume;
}

TEST(RayRegions, NoValueComesOutOfWhatIsCutAway) {
  std::mt19937 random(11);
  for (int round = 0; round < 6; ++round) {
    RaySetup setup;
    setup.frame = {60, 50, 1, {}};
    setup.shown = Box{{3, 0, 2}, {24, 20, 21}};
    setup.viewpoint = viewpoint_at(37 * round, 15 * round - 30);
    setup.angle_degrees = round % 2 == 0 ? 0 : 40;
    setup.brick_shift = 3 + round % 2;
    for (int i = 0; i < round; ++i) {
      const Box box = random_box(random, 12);
      if (!box.is_empty()) setup.removed.push_back(box);
    }
    for (const RayMode mode : {RayMode::volume, RayMode::extreme, RayMode::mean, RayMode::iso}) {
      setup.mode = mode;
      const int mode_number = static_cast<int>(mode);
      const auto low = filled_noise(setup, -200);
      const CastScene scene = cast_scene(low, setup);
      const CastScene other = cast_scene(filled_noise(setup, 900), setup);
      for (std::size_t t = 0; t < scene.field.tiles.size(); ++t) {
        const RayTile& a = scene.field.tiles[t];
        const RayTile& b = other.field.tiles[t];
        for (std::size_t ray = 0; ray < kTileRays; ++ray) {
          // Beside the volume there is no highest value.
          if (std::isinf(a.gathered[ray]) && a.gathered[ray] == b.gathered[ray]) continue;
          // As far as sums of floats are rounded.
          ASSERT_NEAR(a.gathered[ray], b.gathered[ray], 1e-3) << round << ' ' << mode_number;
          if (mode == RayMode::volume) continue;  // light is of gradients, those are of the whole
          ASSERT_NEAR(a.blue[ray], b.blue[ray], 1e-3) << round << ' ' << mode_number;
          if (mode == RayMode::iso) continue;
          ASSERT_NEAR(a.red[ray], b.red[ray], 1e-2) << round << ' ' << mode_number;
        }
      }
      expect_levels_alike(low, setup, scene);
    }
  }
}

/// Where a ray is in a region, if it is.
std::optional<std::pair<double, double>> span_in(const RayRegion& region, const Point3& origin,
                                                 const Point3& direction) {
  double enter = 0;
  double leave = 1e9;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = (static_cast<double>(region.low[axis]) - origin[axis]) / direction[axis];
    const double high = (static_cast<double>(region.high[axis]) - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(low, high));
    leave = std::min(leave, std::max(low, high));
  }
  if (enter + 1e-6 >= leave) return std::nullopt;
  return std::pair(enter, leave);
}

TEST(RayRegions, RaysComeToThemInTheirOrder) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> real(-1, 1);
  for (int round = 0; round < 30; ++round) {
    std::vector<RayRegion> regions;
    for (const Box& box : without_boxes({{0, 0, 0}, {20, 20, 20}},
                                        std::vector<Box>{random_box(random, 20),
                                                         random_box(random, 20)})) {
      regions.push_back(region_of(box));
    }
    RayFrame frame;
    const bool has_eye = round % 2 == 1;
    frame.eye_pixels = has_eye ? 100.0f : 0.0f;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      frame.direction[axis] = static_cast<float>(real(random));
      frame.origin[axis] = static_cast<float>(10 + 25 * real(random));
    }
    const std::vector<RayRegion> ordered = front_to_back(regions, frame);
    for (int ray = 0; ray < 200; ++ray) {
      Point3 origin{10 + 40 * real(random), 10 + 40 * real(random), 10 + 40 * real(random)};
      Point3 direction{real(random), real(random), real(random)};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (has_eye) origin[axis] = static_cast<double>(frame.origin[axis]);
        else direction[axis] = static_cast<double>(frame.direction[axis]);
      }
      double last = -1;
      for (const RayRegion& region : ordered) {
        const auto span = span_in(region, origin, direction);
        if (!span) continue;
        EXPECT_GE(span->first + 1e-6, last);
        last = span->second;
      }
    }
  }
}

/// The eight parts around a place, their faces there inner ones.
std::vector<RayRegion> octants(const Size3& size, const Index3& middle) {
  std::vector<RayRegion> regions;
  for (int i = 0; i < 8; ++i) {
    RayRegion& region = regions.emplace_back(region_of(box_of(size)));
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const bool is_high = (i >> axis & 1) != 0;
      (is_high ? region.low : region.high)[a] = static_cast<float>(middle[axis]);
    }
  }
  return regions;
}

TEST(RayRegions, AVolumeInOctantsIsTheWholeBitForBit) {
  const auto ball = noisy_ball(60);
  for (const RayMode mode : {RayMode::volume, RayMode::extreme, RayMode::mean, RayMode::iso}) {
    for (const double angle : {0.0, 50.0}) {
      for (const FollowRays follow : {follow_rays_portable, follow_rays_function()}) {
        RaySetup setup;
        setup.mode = mode;
        setup.angle_degrees = angle;
        setup.follow = follow;
        const CastScene whole = cast_scene(ball, setup);
        setup.regions = octants(ball.size, {32, 16, 32});
        const auto a = testing::gathered(cast_scene(ball, setup).field);
        const auto b = testing::gathered(whole.field);
        EXPECT_TRUE(a == b) << static_cast<int>(mode) << ' ' << angle;
      }
    }
  }
}

TEST(RayRegions, APiecesFacesCutStepsAndChangeLittle) {
  // A step that is cut is two whose lengths count in parts of 1/64.
  const auto ball = testing::ray_volume<std::int16_t>({60, 60, 60}, [](auto x, auto y, auto z) {
    return 700 - 20 * std::hypot(static_cast<double>(x) - 30, static_cast<double>(y) - 30,
                                 static_cast<double>(z) - 30);
  });
  for (const double angle : {0.0, 50.0}) {
    RaySetup setup;
    setup.angle_degrees = angle;
    const Picture whole = ray_picture(cast_scene(ball, setup).field, {});
    const Box hole{{20, 10, 30}, {50, 40, 60}};
    for (const Box& piece : without_boxes(box_of(ball.size), std::vector<Box>{hole})) {
      setup.regions.push_back(region_of(piece));
    }
    setup.regions.push_back(region_of(hole));
    const Picture pieces = ray_picture(cast_scene(ball, setup).field, {});
    for (std::size_t i = 0; i < whole.pixels.size(); ++i) {
      ASSERT_NEAR(whole.pixels[i], pieces.pixels[i], 3) << i;
    }
  }
}

TEST(RayRegions, WhatLiesInABoxThatIsCutOutIsNotSeen) {
  // A solid block without its middle: rays through the hole see as much as the two ends give.
  auto block = testing::ray_volume<std::int16_t>({40, 40, 40}, [](auto...) { return 400; });
  RaySetup setup;
  setup.viewpoint = *find_viewpoint("front");
  setup.transfer = {{{0, {255, 255, 255}, 0}, {400, {255, 255, 255}, 0.05}}, {}, false};
  for (const Box& piece :
       without_boxes(box_of(block.size), std::vector<Box>{{{0, 10, 0}, {40, 30, 40}}})) {
    setup.regions.push_back(region_of(piece));
  }
  const CastScene cut = cast_scene(block, setup);
  double opacity = 0;
  cut.field.for_each_pixel([&](std::int64_t x, std::int64_t y, const RayTile& tile,
                               std::size_t ray) {
    if (x == 48 && y == 40) opacity = static_cast<double>(tile.gathered[ray]);
  });
  EXPECT_NEAR(opacity, 1 - std::pow(0.95, 20), 1 / 255.0);
}

}  // namespace
}  // namespace octavo
