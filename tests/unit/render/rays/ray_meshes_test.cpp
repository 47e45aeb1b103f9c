#include "octavo/render/rays/ray_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/render/rays/mesh_raster.h"
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
using testing::RayVolume;

/// A surface with normals of its own.
struct OwnedMesh {
  TriangleMesh mesh;
  std::vector<MeshPoint> normals;
  Color color{255, 0, 0};
  double opacity = 0.5;

  RayMesh view() const { return {&mesh, normals, color, opacity}; }
};

/// A square across y, seen from the front: two triangles.
OwnedMesh square_at(double y, double half = 60, const Point3& middle = {19.5, 0, 19.5}) {
  OwnedMesh square;
  for (const auto& [x, z] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    square.mesh.points.push_back({static_cast<float>(middle[0] + x * half), static_cast<float>(y),
                                  static_cast<float>(middle[2] + z * half)});
    square.normals.push_back({0, -1, 0});
  }
  square.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return square;
}

/// A closed surface around a place.
OwnedMesh octahedron(const Point3& middle, double radius) {
  OwnedMesh body;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      Point3 normal{};
      normal[static_cast<std::size_t>(axis)] = sign;
      const Point3 point = sum(middle, scaled(normal, radius));
      body.mesh.points.push_back({static_cast<float>(point[0]), static_cast<float>(point[1]),
                                  static_cast<float>(point[2])});
      body.normals.push_back({static_cast<float>(normal[0]), static_cast<float>(normal[1]),
                              static_cast<float>(normal[2])});
    }
  }
  for (std::uint32_t i = 0; i < 8; ++i) {
    body.mesh.triangles.push_back({i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)});
  }
  return body;
}

RayVolume<std::uint8_t> fog(std::int64_t side = 40) {
  return ray_volume<std::uint8_t>({side, side, side}, [](auto, auto, auto) { return 100; });
}

RaySetup fog_setup(double opacity) {
  RaySetup setup;
  setup.viewpoint = *find_viewpoint("front");
  setup.transfer = {{{100, {0, 255, 0}, opacity}}, {}, false};
  setup.enough = 0.9999f;
  return setup;
}

struct Pixel {
  double red = 0;
  double green = 0;
  double blue = 0;
  double opacity = 0;
};

Pixel pixel_at(const RayField& field, std::int64_t column, std::int64_t row) {
  Pixel pixel;
  field.for_each_pixel([&](auto x, auto y, const RayTile& tile, std::size_t i) {
    if (x == column && y == row) {
      pixel = {tile.red[i], tile.green[i], tile.blue[i], tile.gathered[i]};
    }
  });
  return pixel;
}

/// Light on what faces the viewer, of a full and of an empty channel.
double facing(const RayFrame& frame, double channel) {
  const RayLight& light = frame.light;
  const double shine = std::pow(light.halfway[2], std::pow(2, kShineSquares)) * light.specular;
  return channel * (light.ambient + light.diffuse * light.toward_light[2]) + shine;
}

TEST(RayMeshes, APlaneInFogIsCompositedWhereItLies) {
  const auto cube = fog();
  for (const double opacity : {0.01, 0.06}) {
    // Before, at the face of, inside, at a sample of, and behind the volume.
    for (const double y : {-30.0, -0.5, 7.25, 19.5, 20.0, 33.9, 60.0}) {
      RaySetup setup = fog_setup(opacity);
      const OwnedMesh plane = square_at(y);
      setup.meshes = {plane.view()};
      const CastScene scene = cast_scene(cube, setup);
      const Pixel pixel = pixel_at(scene.field, 48, 40);
      const double steps = std::clamp(y + 0.5, 0.0, 40.0);
      const double left = std::pow(1 - opacity, steps);
      const double all = std::pow(1 - opacity, 40);
      const double glow = kFlatLight * ((1 - left) + 0.5 * (left - all));
      EXPECT_NEAR(pixel.opacity, 1 - 0.5 * all, 1 / 255.0) << y;
      EXPECT_NEAR(pixel.red, 0.5 * left * facing(scene.frame, 1), 1 / 255.0) << y;
      EXPECT_NEAR(pixel.green, glow + 0.5 * left * facing(scene.frame, 0), 1 / 255.0) << y;
    }
  }
}

TEST(RayMeshes, PlanesAreInOrderHoweverTheyAreGiven) {
  const auto cube = fog();
  OwnedMesh red = square_at(30);
  OwnedMesh blue = square_at(10);
  blue.color = {0, 0, 255};
  OwnedMesh white = square_at(20);
  white.color = {255, 255, 255};
  RaySetup setup = fog_setup(0.02);
  setup.meshes = {red.view(), white.view(), blue.view()};
  const CastScene scene = cast_scene(cube, setup);
  const Pixel pixel = pixel_at(scene.field, 48, 40);
  const auto left_at = [](double y) { return std::pow(0.98, y + 0.5); };
  const double full = facing(scene.frame, 1);
  const double none = facing(scene.frame, 0);
  const double first = 0.5 * left_at(10);
  const double second = 0.25 * left_at(20);
  const double third = 0.125 * left_at(30);
  EXPECT_NEAR(pixel.red, first * none + second * full + third * full, 1 / 255.0);
  EXPECT_NEAR(pixel.blue, first * full + second * full + third * none, 1 / 255.0);
  setup.meshes = {blue.view(), red.view(), white.view()};
  EXPECT_EQ(gathered(scene.field), gathered(cast_scene(cube, setup).field));
}

TEST(RayMeshes, ASurfaceHasNoSeamsAndSmoothEdges) {
  const auto empty = ray_volume<std::uint8_t>({40, 40, 40}, [](auto, auto, auto) { return 0; });
  RaySetup setup = fog_setup(0.5);
  setup.transfer = {{{50, {0, 0, 0}, 0}, {100, {0, 0, 0}, 1}}, {}, false};
  OwnedMesh square = square_at(20, 12.3);
  setup.meshes = {square.view()};
  const CastScene scene = cast_scene(empty, setup);
  double sum = 0;
  scene.field.for_each_pixel([&](auto, auto, const RayTile& tile, std::size_t i) {
    const double opacity = tile.gathered[i];
    sum += opacity;
    // Pixels at edges are covered by sixteenths.
    EXPECT_NEAR(opacity * 32, std::round(opacity * 32), 1e-4);
  });
  const double side = 2 * 12.3 / scene.view.pixel_mm;
  EXPECT_NEAR(sum, 0.5 * side * side, 0.005 * side * side);
  const Pixel middle = pixel_at(scene.field, 48, 40);
  EXPECT_NEAR(middle.opacity, 0.5, 1e-6);
}

TEST(RayMeshes, BricksThreadsMemoryAndInstructionSetsChangeNoBit) {
  const auto ball = noisy_ball(70);
  const OwnedMesh inside = octahedron({30, 38, 33}, 25);
  OwnedMesh around = octahedron({34, 34, 34}, 60);
  around.opacity = 0.2;
  around.color = {10, 200, 90};
  for (const RayMode mode : {RayMode::volume, RayMode::iso, RayMode::extreme}) {
    for (const double angle : {0.0, 50.0}) {
      RaySetup setup;
      setup.mode = mode;
      setup.angle_degrees = angle;
      setup.meshes = {inside.view(), around.view()};
      const CastScene first = cast_scene(ball, setup);
      RayLook look;
      look.mode = mode;
      const Picture picture = ray_picture(first.field, look);
      setup.threads = 4;
      setup.brick_shift = 4;
      setup.memory_bytes = 3'000'000;
      const CastScene few = cast_scene(ball, setup);
      EXPECT_EQ(gathered(first.field), gathered(few.field)) << static_cast<int>(mode);
      EXPECT_EQ(picture.pixels, ray_picture(few.field, look).pixels);
      expect_levels_alike(ball, setup, few);
    }
  }
}

TEST(RayMeshes, WhatLiesBehindAnOpaqueSurfaceIsNotSampled) {
  const auto cube = fog(70);
  RaySetup setup = fog_setup(0.001);
  const CastScene open = cast_scene(cube, setup);
  OwnedMesh wall = square_at(1, 200);
  wall.opacity = 1;
  setup.meshes = {wall.view()};
  const CastScene closed = cast_scene(cube, setup);
  EXPECT_LT(10 * closed.field.samples, open.field.samples);
  EXPECT_LT(closed.loaded, open.loaded);
  EXPECT_NEAR(pixel_at(closed.field, 48, 40).opacity, 1, 1e-6);
}

TEST(RayMeshes, AnIsosurfaceHidesWhatLiesBehindIt) {
  const auto slab = ray_volume<std::uint8_t>(
      {40, 40, 40}, [](auto, auto y, auto) { return y >= 20 ? 200 : 0; });
  RaySetup setup = fog_setup(0.5);
  setup.mode = RayMode::iso;
  setup.isovalue = 100;
  RayLook look;
  look.mode = RayMode::iso;
  const auto red_at = [&](double y) {
    const OwnedMesh plane = square_at(y);
    setup.meshes = {plane.view()};
    const Picture picture = ray_picture(cast_scene(slab, setup).field, look);
    return static_cast<int>(picture.pixels[(40 * 96 + 48) * 3]) -
           static_cast<int>(picture.pixels[(40 * 96 + 48) * 3 + 2]);
  };
  // The surface lies at 19.5, between two samples.
  const int plain = red_at(30);
  EXPECT_EQ(red_at(19.6), plain);
  EXPECT_GT(red_at(19.4), plain + 50);
  EXPECT_GT(red_at(-8), plain + 50);
}

TEST(RayMeshes, ProjectionsHaveSurfacesInFront) {
  const auto cube = fog();
  RaySetup setup = fog_setup(0.5);
  RayLook look;
  look.window = {50, 200};
  for (const RayMode mode : {RayMode::extreme, RayMode::mean}) {
    look.mode = setup.mode = mode;
    setup.meshes.clear();
    const CastScene bare = cast_scene(cube, setup);
    const OwnedMesh plane = square_at(38);
    setup.meshes = {plane.view()};
    const CastScene with = cast_scene(cube, setup);
    EXPECT_EQ(gathered(bare.field), gathered(with.field));
    const std::size_t at = (40 * 96 + 48) * 3;
    const int grey = ray_picture(bare.field, look).pixels[at + 1];
    const int mixed = ray_picture(with.field, look).pixels[at + 1];
    EXPECT_NEAR(mixed, 0.5 * grey + 0.5 * 255 * facing(with.frame, 0), 1.5);
  }
}

/// The middle of what a surface covers, pixels.
ScreenPoint middle_of_layers(const CastScene& scene) {
  ScreenPoint middle{};
  double weight = 0;
  scene.field.for_each_pixel([&](auto x, auto y, const RayTile& tile, std::size_t i) {
    middle.x += tile.gathered[i] * (static_cast<double>(x) + 0.5);
    middle.y += tile.gathered[i] * (static_cast<double>(y) + 0.5);
    weight += tile.gathered[i];
  });
  return {middle.x / weight, middle.y / weight};
}

TEST(RayMeshes, MarksStandAtTheirSidesOfThePatientOnEveryGrid) {
  const Geometry grids[] = {
      {},
      {{-7, 100, 3.5}, {0.5, 0.5, 2.5}, {1, 0, 0, 0, 1, 0, 0, 0, 1}},
      {{5, 5, 5}, {1, 2, 0.7}, {0.8, 0, 0.6, 0, 1, 0, 0.6, 0, -0.8}},
      {{0, 0, 0}, {1, 1, 1}, {-1, 0, 0, 0, 0, 1, 0, 1, 0}},
      {{9, -9, 0}, {0.7, 0.9, 1.3}, {0, 0, 1, 0, -1, 0, 1, 0, 0}},
  };
  const Point3 sides[] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};  // L, A, S
  for (const Geometry& geometry : grids) {
    auto volume = ray_volume<std::uint8_t>({30, 24, 20}, [](auto, auto, auto) { return 0; });
    volume.geometry = geometry;
    const Point3 middle = geometry.to_world({14.5, 11.5, 9.5});
    for (const Point3& side : sides) {
      for (const char* viewpoint : {"front", "left", "top", "right-back-bottom"}) {
        RaySetup setup = fog_setup(0.5);
        setup.transfer = {{{50, {0, 0, 0}, 0}, {100, {0, 0, 0}, 1}}, {}, false};
        setup.viewpoint = *find_viewpoint(viewpoint);
        const Point3 place = sum(middle, scaled(side, 4));
        const OwnedMesh mark = octahedron(place, 1.5);
        setup.meshes = {mark.view()};
        const CastScene scene = cast_scene(volume, setup);
        const ScreenPoint seen = middle_of_layers(scene);
        const double pixel = scene.view.pixel_mm;
        EXPECT_NEAR(seen.x, 48 + 4 * dot(side, scene.view.right) / pixel, 0.1) << viewpoint;
        EXPECT_NEAR(seen.y, 40 - 4 * dot(side, scene.view.up) / pixel, 0.1) << viewpoint;
      }
    }
  }
}

TEST(RayMeshes, AnEyeSeesPlanesWhereRaysMeetThem) {
  const auto cube = fog();
  RaySetup setup = fog_setup(0.05);
  setup.angle_degrees = 60;
  const OwnedMesh plane = square_at(19.5);
  setup.meshes = {plane.view()};
  const CastScene scene = cast_scene(cube, setup);
  for (const auto& [column, row] : {std::pair<std::int64_t, std::int64_t>{48, 40}, {10, 70}}) {
    const double u = static_cast<double>(column) + 0.5 - 48;
    const double v = static_cast<double>(row) + 0.5 - 40;
    // The plane through the middle: where rays have come as far as the picture.
    const double eye = scene.frame.eye_pixels;
    const double k = std::sqrt(u * u + v * v + eye * eye) / scene.frame.step_pixels;
    const std::size_t columns = 3;
    const auto tile = static_cast<std::size_t>(row / 32) * columns +
                      static_cast<std::size_t>(column / 32);
    const TileLayers& layers = scene.field.layers[tile];
    for (std::size_t i = 0; i < kTileRays; ++i) {
      if (kTileOrder.column[i] != static_cast<float>(column % 32)) continue;
      if (kTileOrder.row[i] != static_cast<float>(row % 32)) continue;
      ASSERT_EQ(layers.begins[i + 1] - layers.begins[i], 1u);
      EXPECT_NEAR(layers.layers[layers.begins[i]].k, k, 1e-3);
    }
  }
}

TEST(RayMeshes, WhatReachesBehindTheEyeIsCut) {
  const auto cube = fog();
  RaySetup setup = fog_setup(0.001);
  setup.angle_degrees = 90;
  // A floor below the eye, far behind and before it.
  OwnedMesh floor;
  floor.mesh.points = {{-1e6f, -1e6f, 10}, {1e6f, -1e6f, 10}, {0, 1e6f, 10}};
  floor.mesh.triangles = {{0, 1, 2}};
  floor.normals.assign(3, {0, 0, 1});
  floor.opacity = 1;
  setup.meshes = {floor.view()};
  const CastScene scene = cast_scene(cube, setup);
  EXPECT_NEAR(pixel_at(scene.field, 48, 79).opacity, 1, 1e-6);
  EXPECT_LT(pixel_at(scene.field, 48, 0).opacity, 0.5);
}

TEST(RayMeshes, ListsBeyondTheMemoryAreRejected) {
  const auto cube = fog(20);
  RaySetup setup = fog_setup(0.1);
  OwnedMesh many = square_at(5);
  many.opacity = 0.001;
  for (int i = 0; i < 400; ++i) many.mesh.triangles.push_back(many.mesh.triangles[0]);
  setup.meshes = {many.view()};
  setup.memory_bytes = 1'000'000;
  try {
    cast_scene(cube, setup);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    EXPECT_EQ(error.field(), "meshes.memory");
  }
}

}  // namespace
}  // namespace octavo
