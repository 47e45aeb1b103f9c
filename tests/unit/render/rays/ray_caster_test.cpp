#include "octavo/render/rays/ray_caster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::CastScene;
using testing::cast_scene;
using testing::expect_levels_alike;
using testing::gathered;
using testing::noisy_ball;
using testing::place_of_hit;
using testing::ray_volume;
using testing::RaySetup;
using testing::RayVolume;

constexpr RayMode kAllModes[] = {RayMode::volume, RayMode::extreme, RayMode::mean, RayMode::iso};

const RayTile& tile_at(const RayField& field, std::int64_t column, std::int64_t row,
                       std::size_t& ray) {
  std::size_t tile = 0;
  field.for_each_pixel([&](auto x, auto y, const RayTile& one, std::size_t i) {
    if (x != column || y != row) return;
    tile = static_cast<std::size_t>(&one - field.tiles.data());
    ray = i;
  });
  return field.tiles[tile];
}

TEST(RayCaster, AConstantCubeHasTheOpacityOfItsThickness) {
  const auto cube =
      ray_volume<std::uint8_t>({40, 40, 40}, [](auto, auto, auto) { return 100; });
  RaySetup setup;
  setup.viewpoint = *find_viewpoint("front");
  for (const double opacity : {0.002, 0.02, 0.1}) {
    setup.transfer = {{{100, {255, 255, 255}, opacity}}, {}, false};
    const CastScene scene = cast_scene(cube, setup);
    std::size_t ray = 0;
    const RayTile& tile = tile_at(scene.field, 48, 40, ray);
    EXPECT_NEAR(tile.gathered[ray], 1 - std::pow(1 - opacity, 40), 1 / 255.0) << opacity;
    EXPECT_NEAR(tile.red[ray], kFlatLight * tile.gathered[ray], 1 / 255.0) << opacity;
  }
}

TEST(RayCaster, WhatIsSkippedChangesNoBit) {
  const auto ball = noisy_ball(70);
  for (const RayMode mode : kAllModes) {
    RaySetup setup;
    setup.mode = mode;
    const CastScene skipping = cast_scene(ball, setup);
    setup.skips = false;
    const CastScene taking = cast_scene(ball, setup);
    EXPECT_EQ(gathered(skipping.field), gathered(taking.field)) << static_cast<int>(mode);
    if (mode == RayMode::volume || mode == RayMode::iso) {
      EXPECT_LT(skipping.field.samples, taking.field.samples);
    }
  }
}

TEST(RayCaster, BricksThreadsAndMemoryChangeNoBit) {
  const auto ball = noisy_ball(70);
  for (const RayMode mode : kAllModes) {
    for (const double angle : {0.0, 50.0}) {
      RaySetup setup;
      setup.mode = mode;
      setup.angle_degrees = angle;
      const CastScene first = cast_scene(ball, setup);
      setup.threads = 4;
      setup.brick_shift = 4;
      const CastScene small = cast_scene(ball, setup);
      setup.memory_bytes = 200'000;
      const CastScene few = cast_scene(ball, setup);
      EXPECT_EQ(gathered(first.field), gathered(small.field)) << static_cast<int>(mode);
      EXPECT_EQ(gathered(first.field), gathered(few.field)) << static_cast<int>(mode);
      EXPECT_GE(few.loaded, small.loaded);
      // One by one rays take the same samples.
      setup.follow = follow_rays_portable;
      const CastScene single = cast_scene(ball, setup);
      setup.memory_bytes = RaySetup{}.memory_bytes;
      setup.brick_shift = RaySetup{}.brick_shift;
      EXPECT_EQ(cast_scene(ball, setup).field.samples, single.field.samples);
      EXPECT_EQ(gathered(first.field), gathered(single.field)) << static_cast<int>(mode);
    }
  }
}

template <class T>
void expect_modes_alike(const RayVolume<T>& volume, float sign, float gradient_rise = 0) {
  for (const RayMode mode : kAllModes) {
    for (const double angle : {0.0, 40.0}) {
      RaySetup setup;
      setup.mode = mode;
      setup.sign = sign;
      setup.gradient_rise = gradient_rise;
      setup.angle_degrees = angle;
      setup.frame = {50, 41, 1, {}};
      setup.isovalue = 225.25;
      setup.follow = follow_rays_portable;
      expect_levels_alike(volume, setup, cast_scene(volume, setup));
    }
  }
}

TEST(RayCaster, AllInstructionSetsGiveTheSameBits) {
  const auto ball = noisy_ball(40);
  expect_modes_alike(ball, 1);
  expect_modes_alike(ball, -1);
  expect_modes_alike(ball, 1, 0.01f);
  RayVolume<float> wide{ball.size, {{}, {1, 2, 0.7}, {0.8, 0, 0.6, 0, 1, 0, 0.6, 0, -0.8}}, {}};
  wide.samples.assign(ball.samples.begin(), ball.samples.end());
  expect_modes_alike(wide, 1);
}

TEST(RayCaster, GradientsOfCellsGiveTheSameLightOnASlope) {
  const auto slope = ray_volume<std::int16_t>({40, 40, 40}, [](auto x, auto y, auto z) {
    return 10 * x + 6 * y + 3 * z;
  });
  RaySetup setup;
  // A layer across the volume.
  const Color white = {255, 255, 255};
  setup.transfer = {{{360, white, 0}, {370, white, 0.9}, {380, white, 0}}, {}, false};
  const CastScene whole = cast_scene(slope, setup);
  setup.has_cell_gradients = true;
  const CastScene cells = cast_scene(slope, setup);
  const std::vector<float> a = gathered(whole.field);
  const std::vector<float> b = gathered(cells.field);
  std::size_t near = 0;
  for (std::size_t i = 0; i < a.size(); ++i) near += std::abs(a[i] - b[i]) < 0.01f;
  // Beside the faces, where samples are repeated, central differences are halved.
  EXPECT_GT(near, a.size() * 97 / 100);
  expect_levels_alike(slope, setup, cells);
}

TEST(RayCaster, ARayThatEndsEarlyMissesLessThanTwoOf255) {
  const auto ball = noisy_ball(70);
  RaySetup setup;
  const Picture early = ray_picture(cast_scene(ball, setup).field, {});
  setup.enough = 2;
  const Picture late = ray_picture(cast_scene(ball, setup).field, {});
  ASSERT_NE(early.pixels, late.pixels);
  for (std::size_t i = 0; i < early.pixels.size(); ++i) {
    ASSERT_LE(std::abs(early.pixels[i] - late.pixels[i]), 2);
  }
}

TEST(RayCaster, APlaneIsHitWithinAThousandthOfAVoxel) {
  const auto slope = ray_volume<float>({40, 40, 40}, [](auto x, auto y, auto z) {
    return 2 * static_cast<double>(x) - static_cast<double>(y) + 0.5 * static_cast<double>(z);
  });
  RaySetup setup;
  setup.mode = RayMode::iso;
  setup.isovalue = 30.3;
  setup.viewpoint = viewpoint_at(-70, 20);
  const CastScene scene = cast_scene(slope, setup);
  std::int64_t hits = 0;
  scene.field.for_each_pixel([&](auto column, auto row, const RayTile& tile, std::size_t ray) {
    const Point3 p = place_of_hit(scene, column, row, tile.blue[ray]);
    const double margin = std::min({p[0], p[1], p[2], 39 - p[0], 39 - p[1], 39 - p[2]});
    if (tile.gathered[ray] == 0 || margin < 1) return;
    ++hits;
    const double off = 2 * p[0] - p[1] + 0.5 * p[2] - setup.isovalue;
    ASSERT_LT(std::abs(off) / std::sqrt(5.25), 1e-3);
  });
  EXPECT_GT(hits, 500);
}

TEST(RayCaster, ASphereIsHitWithinAThousandthOfAVoxel) {
  // Distances between samples are straight to 1 / (8 * radius) of a voxel along each axis.
  constexpr double kRadius = 300;
  const Point3 middle = {-260, 18, 18};
  const auto sphere = ray_volume<float>({60, 36, 36}, [&](auto x, auto y, auto z) {
    return kRadius - std::hypot(static_cast<double>(x) - middle[0],
                                static_cast<double>(y) - middle[1],
                                static_cast<double>(z) - middle[2]);
  });
  RaySetup setup;
  setup.mode = RayMode::iso;
  setup.isovalue = 0;
  setup.viewpoint = viewpoint_at(90, 0);
  const CastScene scene = cast_scene(sphere, setup);
  std::int64_t hits = 0;
  scene.field.for_each_pixel([&](auto column, auto row, const RayTile& tile, std::size_t ray) {
    const Point3 p = place_of_hit(scene, column, row, tile.blue[ray]);
    const double margin = std::min({p[1], p[2], 35 - p[1], 35 - p[2]});
    if (tile.gathered[ray] == 0 || margin < 1) return;
    ++hits;
    const Point3 off = difference(p, middle);
    ASSERT_NEAR(std::sqrt(dot(off, off)), kRadius, 1e-3);
  });
  EXPECT_GT(hits, 500);
}

TEST(RayCaster, AnEyeInsideSeesAllAroundIt) {
  const auto shell = ray_volume<float>({40, 40, 40}, [](auto x, auto y, auto z) {
    return std::hypot(static_cast<double>(x) - 19.5, static_cast<double>(y) - 19.5,
                      static_cast<double>(z) - 19.5);
  });
  RaySetup setup;
  setup.mode = RayMode::iso;
  setup.isovalue = 17;
  setup.angle_degrees = 150;
  const CastScene scene = cast_scene(shell, setup);
  const RayFrame& f = scene.frame;
  ASSERT_LT(std::hypot(f.origin[0] - 19.5f, f.origin[1] - 19.5f, f.origin[2] - 19.5f), 12);
  scene.field.for_each_pixel([&](auto column, auto row, const RayTile& tile, std::size_t ray) {
    ASSERT_EQ(tile.gathered[ray], 1) << column << ' ' << row;
    const double u = static_cast<double>(column) + 0.5 - static_cast<double>(scene.view.width) / 2;
    const double v = static_cast<double>(row) + 0.5 - static_cast<double>(scene.view.height) / 2;
    const double steps = tile.blue[ray] * f.step_pixels / std::hypot(u, v, f.eye_pixels);
    Point3 off;
    for (std::size_t i = 0; i < 3; ++i) {
      off[i] = f.origin[i] - 19.5 +
               steps * (f.direction[i] + u * f.direction_across[i] + v * f.direction_down[i]);
    }
    ASSERT_NEAR(std::sqrt(dot(off, off)), 17, 0.02);
  });
  setup.mode = RayMode::volume;
  setup.follow = follow_rays_portable;
  expect_levels_alike(shell, setup, cast_scene(shell, setup));
}

TEST(RayCaster, AnEyeInAThinPlateSeesItsValues) {
  const auto plate = ray_volume<std::int16_t>({40, 1, 40}, [](auto, auto, auto) { return 300; });
  RaySetup setup;
  setup.mode = RayMode::extreme;
  setup.frame = {64, 64, 1, 0.02};
  setup.viewpoint = viewpoint_at(70, 10);
  setup.angle_degrees = 150;
  for (const float sign : {1.0f, -1.0f}) {
    setup.sign = sign;
    const CastScene scene = cast_scene(plate, setup);
    // Some rays turn away from the middle of the plate.
    ASSERT_LT(std::abs(scene.frame.origin[1]), 0.5f);
    ASSERT_GT(std::abs(scene.frame.origin[1]), 0.01f);
    scene.field.for_each_pixel([&](auto, auto, const RayTile& tile, std::size_t ray) {
      ASSERT_EQ(tile.gathered[ray], sign * 300);
    });
    expect_levels_alike(plate, setup, scene);
  }
}

TEST(RayCaster, AHighVoxelKeepsItsHeightFromAllSides) {
  auto point = ray_volume<std::int16_t>({21, 20, 23}, [](auto x, auto y, auto z) {
    return x == 9 && y == 11 && z == 12 ? 1000 : 0;
  });
  point.geometry.spacing_mm = {1, 1.2, 0.9};
  RaySetup setup;
  setup.mode = RayMode::extreme;
  setup.frame = {240, 240, 1, {}};
  for (const double angle : {0.0, 45.0}) {
    setup.angle_degrees = angle;
    for (const double azimuth : {0.0, 17.0, 45.0, 73.0, 110.0, 208.0}) {
      for (const double elevation : {0.0, 20.0, 35.26}) {
        setup.viewpoint = viewpoint_at(azimuth, elevation);
        const CastScene scene = cast_scene(point, setup);
        const std::vector<double> values = ray_values(scene.field, RayMode::extreme, 1);
        EXPECT_GT(*std::max_element(values.begin(), values.end()), 850)
            << azimuth << ' ' << elevation << ' ' << angle;
      }
    }
  }
}

/// Pixels of a picture from the middles of which a ray through the box of a volume runs.
std::int64_t pixels_on_box(const CastScene& scene) {
  std::int64_t pixels = 0;
  scene.field.for_each_pixel([&](auto column, auto row, const RayTile&, std::size_t) {
    const Point3 from = place_of_hit(scene, column, row, 0);
    const Point3 to = place_of_hit(scene, column, row, 1000);
    double enter = 0;
    double leave = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double a = (scene.frame.low[i] - from[i]) / (to[i] - from[i]);
      const double b = (scene.frame.high[i] - from[i]) / (to[i] - from[i]);
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (enter <= leave) ++pixels;
  });
  return pixels;
}

TEST(RayCaster, WhatIsThinnerThanAStepHasNoGaps) {
  for (const std::int64_t side : {2, 13}) {
    const auto cube =
        ray_volume<std::uint8_t>({side, side, side}, [](auto, auto, auto) { return 100; });
    RaySetup setup;
    setup.isovalue = 50;
    setup.frame = {300, 300, 1, {}};
    for (const RayMode mode : {RayMode::iso, RayMode::extreme}) {
      setup.mode = mode;
      const CastScene scene = cast_scene(cube, setup);
      std::int64_t seen = 0;
      scene.field.for_each_pixel([&](auto, auto, const RayTile& tile, std::size_t ray) {
        if (tile.gathered[ray] > 0) ++seen;
      });
      EXPECT_NEAR(static_cast<double>(seen), static_cast<double>(pixels_on_box(scene)), 5)
          << side << ' ' << static_cast<int>(mode);
    }
  }
}

TEST(RayCaster, AThinPlateIsEvenlyOpaque) {
  const auto plate = ray_volume<std::int16_t>(
      {40, 40, 40}, [](auto, auto, auto z) { return z == 20 ? 500 : 0; });
  RaySetup setup;
  setup.transfer = {{{250, {255, 255, 255}, 0}, {250, {255, 255, 255}, 0.1}}, {}, false, {}};
  for (const double elevation : {30.0, 45.0, 60.0, 90.0}) {
    setup.viewpoint = viewpoint_at(20, elevation);
    const CastScene scene = cast_scene(plate, setup);
    double lowest = 1;
    double highest = 0;
    for (std::int64_t row = 36; row < 44; ++row) {
      for (std::int64_t column = 40; column < 56; ++column) {
        std::size_t ray = 0;
        const RayTile& tile = tile_at(scene.field, column, row, ray);
        lowest = std::min(lowest, static_cast<double>(tile.gathered[ray]));
        highest = std::max(highest, static_cast<double>(tile.gathered[ray]));
      }
    }
    // Half a voxel on each side of the plane is above 250.
    const double length = 1 / std::sin(elevation * std::numbers::pi / 180);
    EXPECT_NEAR(lowest, 1 - std::pow(0.9, length), 0.02) << elevation;
    EXPECT_NEAR(highest, 1 - std::pow(0.9, length), 0.02) << elevation;
  }
}

TEST(RayCaster, OpacityFollowsTheGradientWhereItIsAsked) {
  // Flat above the middle, steep below it.
  const auto slope = ray_volume<std::int16_t>(
      {30, 30, 30}, [](auto, auto, auto z) { return z < 15 ? 20 * z : 300; });
  RaySetup setup;
  setup.transfer = {{{1, {255, 255, 255}, 0.05}}, {}, false, {}};
  setup.viewpoint = *find_viewpoint("front");
  setup.gradient_begin = 5;
  setup.gradient_rise = 0.1f;
  const CastScene scene = cast_scene(slope, setup);
  std::size_t flat = 0;
  std::size_t steep = 0;
  const RayTile& above = tile_at(scene.field, 48, 25, flat);
  const RayTile& below = tile_at(scene.field, 48, 55, steep);
  EXPECT_EQ(above.gathered[flat], 0);
  EXPECT_NEAR(below.gathered[steep], 1 - std::pow(0.95, 30), 0.01);
}

TEST(RayCaster, ZoomEnlargesWhatAnEyeSees) {
  const auto ball = noisy_ball(48);
  RaySetup setup;
  setup.mode = RayMode::iso;
  setup.angle_degrees = 60;
  setup.frame = {51, 51, 1, {}};
  const CastScene whole = cast_scene(ball, setup);
  setup.frame.zoom = 3;
  const CastScene zoomed = cast_scene(ball, setup);
  // The ray of a pixel is that of the pixel three times as far from the middle.
  for (std::int64_t row = -8; row <= 8; row += 4) {
    for (std::int64_t column = -8; column <= 8; column += 4) {
      std::size_t a = 0;
      std::size_t b = 0;
      const RayTile& near = tile_at(whole.field, 25 + column, 25 + row, a);
      const RayTile& far = tile_at(zoomed.field, 25 + 3 * column, 25 + 3 * row, b);
      ASSERT_EQ(near.gathered[a], far.gathered[b]) << column << ' ' << row;
      EXPECT_NEAR(near.blue[a], far.blue[b], 1e-2) << column << ' ' << row;
    }
  }
}

struct GridCase {
  const char* name;
  Geometry geometry;
};

/// A mark stands where it stands in the patient, whatever the axes of the grid.
TEST(RayCaster, GridsOfAllKindsShowAMarkAtItsPlace) {
  const double s = std::sqrt(0.5);
  const GridCase cases[] = {
      {"straight", {{}, {1, 1, 1}, {1, 0, 0, 0, 1, 0, 0, 0, 1}}},
      {"anisotropic", {{5, -3, 9}, {0.5, 1, 2.5}, {1, 0, 0, 0, 1, 0, 0, 0, 1}}},
      {"left-handed", {{}, {1, 1, 1}, {1, 0, 0, 0, 1, 0, 0, 0, -1}}},
      {"oblique", {{}, {1, 0.8, 1.5}, {s, -s, 0, s, s, 0, 0, 0, 1}}},
      {"permuted", {{1, 2, 3}, {1, 1, 2}, {0, 1, 0, 0, 0, 1, 1, 0, 0}}}};
  const Index3 mark{26, 9, 17};
  auto volume = ray_volume<std::uint8_t>({36, 30, 28}, [&](auto x, auto y, auto z) {
    return std::max({std::abs(x - mark.x), std::abs(y - mark.y), std::abs(z - mark.z)}) <= 1 ? 200
                                                                                            : 0;
  });
  for (const GridCase& one : cases) {
    volume.geometry = one.geometry;
    for (const char* side : {"front", "left", "top", "left-front-top"}) {
      RaySetup setup;
      setup.mode = RayMode::iso;
      setup.isovalue = 100;
      setup.viewpoint = *find_viewpoint(side);
      const CastScene scene = cast_scene(volume, setup);
      double x = 0;
      double y = 0;
      double hits = 0;
      scene.field.for_each_pixel([&](auto column, auto row, const RayTile& tile, std::size_t ray) {
        if (tile.gathered[ray] == 0) return;
        x += static_cast<double>(column) + 0.5;
        y += static_cast<double>(row) + 0.5;
        ++hits;
      });
      ASSERT_GT(hits, 0) << one.name << ' ' << side;
      const Point3 off = difference(one.geometry.to_world({26, 9, 17}),
                                    one.geometry.to_world({17.5, 14.5, 13.5}));
      EXPECT_NEAR(x / hits, 48 + dot(off, scene.view.right) / scene.view.pixel_mm, 1)
          << one.name << ' ' << side;
      EXPECT_NEAR(y / hits, 40 - dot(off, scene.view.up) / scene.view.pixel_mm, 1)
          << one.name << ' ' << side;
    }
  }
}

TEST(RayCaster, LightFallsAlikeOnAMirroredGrid) {
  auto ball = noisy_ball(48);
  RaySetup setup;
  setup.mode = RayMode::iso;
  RayLook look;
  look.mode = RayMode::iso;
  const Picture straight = ray_picture(cast_scene(ball, setup).field, look);
  // The same ball with its planes from the other end.
  const auto plane = static_cast<std::ptrdiff_t>(ball.size.x * ball.size.y);
  for (std::ptrdiff_t low = 0, high = 47; low < high; ++low, --high) {
    std::swap_ranges(ball.samples.begin() + low * plane, ball.samples.begin() + (low + 1) * plane,
                     ball.samples.begin() + high * plane);
  }
  ball.geometry.direction = {1, 0, 0, 0, 1, 0, 0, 0, -1};
  const Picture mirrored = ray_picture(cast_scene(ball, setup).field, look);
  std::size_t differing = 0;
  for (std::size_t i = 0; i < straight.pixels.size(); ++i) {
    if (std::abs(straight.pixels[i] - mirrored.pixels[i]) > 2) ++differing;
  }
  EXPECT_LT(differing, straight.pixels.size() / 200);
}

TEST(RayCaster, NearThingsAreLargerThroughAnEye) {
  const auto two = ray_volume<std::uint8_t>({40, 40, 40}, [](auto x, auto y, auto z) {
    const bool is_row = std::abs(z - 20) <= 2 && std::abs(x - (y < 20 ? 10 : 30)) <= 2;
    return is_row && (std::abs(y - 5) <= 2 || std::abs(y - 35) <= 2) ? 200 : 0;
  });
  RaySetup setup;
  setup.mode = RayMode::iso;
  setup.isovalue = 100;
  setup.viewpoint = *find_viewpoint("front");
  const auto halves = [&] {
    std::array<int, 2> hits{};
    const CastScene scene = cast_scene(two, setup);
    scene.field.for_each_pixel([&](auto column, auto, const RayTile& tile, std::size_t ray) {
      if (tile.gathered[ray] > 0) ++hits[column < 48 ? 0 : 1];
    });
    return hits;
  };
  const auto parallel = halves();
  EXPECT_NEAR(parallel[0], parallel[1], 0.1 * parallel[0]);
  setup.angle_degrees = 60;
  const auto seen = halves();
  EXPECT_GT(seen[0], 1.5 * seen[1]);
}

TEST(RayCaster, BricksThatNoRayComesToAreNotLoaded) {
  // A wall before noise, and nothing beside it.
  const auto wall = ray_volume<std::int16_t>({128, 128, 64}, [](auto x, auto y, auto z) {
    if (x >= 64) return std::int64_t{0};
    return y < 16 ? std::int64_t{1000} : (x + y + z) % 7 * 100;
  });
  RaySetup setup;
  setup.transfer = {{{100, {255, 255, 255}, 0}, {900, {255, 255, 255}, 0.9}}, {}, false};
  setup.viewpoint = *find_viewpoint("front");
  setup.brick_shift = 5;
  const CastScene scene = cast_scene(wall, setup);
  // 2 x 2 bricks of the wall; others give the samples between it and what is beside it.
  EXPECT_LE(scene.loaded, 4 * 2);
  EXPECT_GE(scene.loaded, 4);
}

TEST(RayCaster, HighestLowestAndMeanAreThoseOfTheSamples) {
  const auto ramp = ray_volume<std::uint16_t>(
      {20, 20, 20}, [](auto, auto y, auto) { return 40000 + 100 * y; });
  RaySetup setup;
  setup.viewpoint = *find_viewpoint("front");
  const auto value = [&] {
    const CastScene scene = cast_scene(ramp, setup);
    std::size_t ray = 0;
    const RayTile& tile = tile_at(scene.field, 48, 40, ray);
    const double pooled = setup.mode == RayMode::mean ? tile.red[ray] / tile.gathered[ray]
                                                      : tile.gathered[ray] * setup.sign;
    return scene.scale.stored(pooled);
  };
  setup.mode = RayMode::extreme;
  EXPECT_NEAR(value(), 41900, 1);
  setup.sign = -1;
  EXPECT_NEAR(value(), 40000, 1);
  setup.mode = RayMode::mean;
  EXPECT_NEAR(value(), 40950, 1);
}

TEST(RayCaster, FloatsThatAreNotFiniteCountAsTheLowestOrHighest) {
  auto volume = ray_volume<float>({16, 16, 16}, [](auto x, auto, auto) { return x; });
  volume.samples[700] = std::numeric_limits<float>::quiet_NaN();
  volume.samples[900] = std::numeric_limits<float>::infinity();
  for (const RayMode mode : kAllModes) {
    RaySetup setup;
    setup.mode = mode;
    setup.isovalue = 7;
    for (const float one : gathered(cast_scene(volume, setup).field)) ASSERT_FALSE(std::isnan(one));
  }
}

TEST(RayCaster, InfiniteVoxelsAmongEqualOnesCountAsThese) {
  auto volume = ray_volume<float>({16, 16, 16}, [](auto, auto, auto) { return 500; });
  volume.samples[2184] = std::numeric_limits<float>::infinity();
  volume.samples[2000] = -std::numeric_limits<float>::infinity();
  RaySetup setup;
  setup.mode = RayMode::extreme;
  const CastScene scene = cast_scene(volume, setup);
  for (const double value : ray_values(scene.field, RayMode::extreme, 1)) {
    ASSERT_EQ(scene.scale.stored(value), 500);
  }
}

TEST(RayCaster, MemoryForNotEvenOneBrickIsRejected) {
  const auto ball = noisy_ball(70);
  RaySetup setup;
  setup.memory_bytes = 100'000;
  try {
    cast_scene(ball, setup);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    EXPECT_NE(std::string(error.what()).find("100000 bytes"), std::string::npos);
  }
}

}  // namespace
}  // namespace octavo
