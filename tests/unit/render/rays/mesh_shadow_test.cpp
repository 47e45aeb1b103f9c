#include "octavo/render/rays/mesh_shadow.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/render/rays/ray_shade.h"
#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::CastScene;
using testing::cast_scene;
using testing::expect_levels_alike;
using testing::gathered;
using testing::noisy_ball;
using testing::place_of_hit;
using testing::RaySetup;

/// Across z: x and y from low to high.
TriangleMesh sheet(double low, double high, double z) {
  TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair{low, low}, {high, low}, {high, high}, {low, high}}) {
    mesh.points.push_back(
        {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

RayMesh shadow_of(const TriangleMesh& mesh, double opacity) { return {&mesh, {}, {}, opacity}; }

Point3 middle_of(const TriangleMesh& mesh, const MeshTriangle& triangle) {
  Point3 middle{};
  for (const std::uint32_t corner : triangle) {
    const MeshPoint& p = mesh.points[corner];
    middle = sum(middle, scaled({p[0], p[1], p[2]}, 1.0 / 3));
  }
  return middle;
}

/// A grid in which nothing takes light.
RayShade clear_shade() {
  const NoProgress silent;
  return RayShade({{3, 3, 3}, {}, std::vector<float>(27, 0.0f)}, silent);
}

TEST(MeshShadows, ASheetAboveABallDarkensExactlyWhatLiesUnderIt) {
  const auto ball = noisy_ball(60);
  const NoProgress silent;
  const Point3 toward = unit({0.3, -0.4, 0.8});
  const TriangleMesh above = sheet(25, 43, 70);
  RayShade clear = clear_shade();
  RaySetup setup;
  setup.mode = RayMode::iso;
  setup.isovalue = 200;
  setup.viewpoint = viewpoint_at(20, 50);
  setup.frame = {192, 160, 1, {}};
  setup.shade = clear.table(ball.geometry, false);
  const CastScene bright = cast_scene(ball, setup);
  const auto cast_behind = [&](double opacity) {
    const MeshShadow shadow({shadow_of(above, opacity)}, {ball.geometry, toward, 0.5}, silent);
    RaySetup behind = setup;
    behind.shade.meshes = &shadow;
    return cast_scene(ball, behind);
  };
  const CastScene dark = cast_behind(1);
  const CastScene half = cast_behind(0.5);
  EXPECT_EQ(gathered(cast_behind(0).field), gathered(bright.field));
  int under = 0;
  int lit = 0;
  for (std::size_t t = 0; t < bright.field.tiles.size(); ++t) {
    const RayTile& of_bright = bright.field.tiles[t];
    const auto left = static_cast<std::int64_t>(t) % bright.field.tile_columns() * kRayTileSide;
    const auto top = static_cast<std::int64_t>(t) / bright.field.tile_columns() * kRayTileSide;
    for (std::size_t i = 0; i < kTileRays; ++i) {
      if (!(of_bright.gathered[i] > 0)) continue;
      const Point3 place = place_of_hit(
          bright, left + static_cast<std::int64_t>(kTileOrder.column[i]),
          top + static_cast<std::int64_t>(kTileOrder.row[i]), of_bright.blue[i]);
      const Point3 at_sheet = sum(place, scaled(toward, (70 - place[2]) / toward[2]));
      const double inside = std::min({at_sheet[0] - 25, 43 - at_sheet[0], at_sheet[1] - 25,
                                      43 - at_sheet[1]});
      if (std::abs(inside) < 1e-3) continue;
      const float red = of_bright.red[i];
      const float red_dark = dark.field.tiles[t].red[i];
      if (inside > 0) {
        ++under;
        EXPECT_LT(red_dark, red);
        EXPECT_NEAR(half.field.tiles[t].red[i], (red + red_dark) / 2, 1e-5);
        EXPECT_NEAR(dark.field.tiles[t].green[i], kDeepestShadow * of_bright.green[i], 1e-5);
      } else {
        ++lit;
        EXPECT_EQ(red_dark, red);
        EXPECT_EQ(half.field.tiles[t].red[i], red);
      }
    }
  }
  EXPECT_GT(under, 200);
  EXPECT_GT(lit, 200);
}

TEST(MeshShadows, AllInstructionSetsAndThreadsGiveTheSameBits) {
  const auto ball = noisy_ball(40);
  const NoProgress silent;
  const TriangleMesh above = sheet(5, 22, 30);
  const MeshShadow shadow({shadow_of(above, 0.7)}, {ball.geometry, unit({0.2, 0.1, 1}), 0.5},
                          silent);
  RayShade clear = clear_shade();
  for (const RayMode mode : {RayMode::volume, RayMode::iso}) {
    RaySetup setup;
    setup.mode = mode;
    setup.follow = follow_rays_portable;
    setup.shade = clear.table(ball.geometry, false);
    const CastScene bright = cast_scene(ball, setup);
    setup.shade.meshes = &shadow;
    const CastScene portable = cast_scene(ball, setup);
    EXPECT_NE(gathered(portable.field), gathered(bright.field));
    setup.threads = 4;
    EXPECT_EQ(gathered(cast_scene(ball, setup).field), gathered(portable.field));
    expect_levels_alike(ball, setup, portable);
  }
}

TEST(MeshShadows, TrianglesThatShareEdgesTakeLightOnce) {
  // A hilly sheet; light that crosses it crosses it once, also through its points and edges.
  constexpr std::uint32_t kSide = 20;
  TriangleMesh hills;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> noise(-0.3f, 0.3f);
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    hills.points.push_back({static_cast<float>(i % kSide) + noise(random),
                            static_cast<float>(i / kSide) + noise(random), noise(random)});
  }
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t at = y * kSide + x;
      hills.triangles.push_back({at, at + 1, at + kSide + 1});
      hills.triangles.push_back({at + kSide, at, at + kSide + 1});
    }
  }
  const NoProgress silent;
  for (const Point3& toward : {Point3{0, 0, 1}, unit({0.2, -0.1, 1})}) {
    const MeshShadow shadow({shadow_of(hills, 0.5)}, {{}, toward, 0.5}, silent);
    const auto expect_once = [&](const Point3& on) {
      EXPECT_EQ(shadow.passed(difference(on, scaled(toward, 9))), 0.5);
      EXPECT_EQ(shadow.passed(sum(on, scaled(toward, 9))), 1);
    };
    for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
      const std::uint32_t x = i % kSide;
      const std::uint32_t y = i / kSide;
      if (x == 0 || y == 0 || x + 1 == kSide || y + 1 == kSide) continue;
      const Point3 a{hills.points[i][0], hills.points[i][1], hills.points[i][2]};
      const MeshPoint& next = hills.points[i + 1];
      expect_once(a);
      expect_once(scaled(sum(a, {next[0], next[1], next[2]}), 0.5));
    }
  }
}

TEST(MeshShadows, AgreeWithEachTriangleAsked) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-10, 10);
  const auto any = [&] { return Point3{place(random), place(random), place(random)}; };
  TriangleMesh soup;
  for (std::uint32_t i = 0; i < 600; ++i) {
    const Point3 middle = any();
    for (int corner = 0; corner < 3; ++corner) {
      const Point3 p = sum(middle, scaled(any(), i % 50 == 0 ? 1.0 : 0.1));
      soup.points.push_back({static_cast<float>(p[0]), static_cast<float>(p[1]),
                             static_cast<float>(p[2])});
    }
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Point3 toward = unit({0.5, 0.7, -0.2});
  Geometry geometry;
  geometry.spacing_mm = {0.5, 2, 1};
  geometry.origin_mm = {3, -2, 1};
  const NoProgress silent;
  const MeshShadow shadow({shadow_of(soup, 0.25)}, {geometry, toward, 0.01}, silent);
  int counted = 0;
  for (int i = 0; i < 2000; ++i) {
    const Point3 from = any();
    int crossed = 0;
    bool is_close = false;
    for (const MeshTriangle& triangle : soup.triangles) {
      std::array<Point3, 3> to;
      for (std::size_t c = 0; c < 3; ++c) {
        const MeshPoint& p = soup.points[triangle[c]];
        to[c] = difference({p[0], p[1], p[2]}, from);
      }
      const Point3 normal = cross(difference(to[1], to[0]), difference(to[2], to[0]));
      const double t = dot(normal, to[0]) / dot(normal, toward);
      double share = 1;
      for (std::size_t c = 0; c < 3; ++c) {
        const double volume = dot(toward, cross(to[(c + 1) % 3], to[(c + 2) % 3]));
        share = std::min(share, volume / dot(normal, toward));
      }
      is_close = is_close || std::abs(share) < 1e-4 || (share > 0 && std::abs(t - 0.01) < 1e-3);
      if (share > 0 && t > 0.01) ++crossed;
    }
    if (is_close) continue;
    ++counted;
    const double expected = std::pow(0.75, crossed);
    EXPECT_NEAR(shadow.passed(from), expected < 1 / 400.0 ? 0 : expected, 1e-9);
    EXPECT_NEAR(shadow.passed_at_sample(geometry.to_index(from)),
                expected < 1 / 400.0 ? 0 : expected, 1e-9);
  }
  EXPECT_GT(counted, 1500);
}

TEST(MeshShadows, AClosedSurfaceShadesItsFarSideAlone) {
  TriangleMesh body;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-5.0f, 5.0f}) {
      MeshPoint point{};
      point[static_cast<std::size_t>(axis)] = sign;
      body.points.push_back(point);
    }
  }
  for (std::uint32_t i = 0; i < 8; ++i) {
    body.triangles.push_back({i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)});
  }
  const NoProgress silent;
  const Point3 toward = unit({0.3, 0.2, 0.9});
  const MeshShadow shadow({shadow_of(body, 0.5)}, {{}, toward, 0.1}, silent);
  for (const MeshTriangle& triangle : body.triangles) {
    const Point3 middle = middle_of(body, triangle);
    EXPECT_EQ(shadow.passed(middle), dot(middle, toward) > 0 ? 1 : 0.5);
  }
  EXPECT_EQ(shadow.passed(scaled(toward, -20)), 0.25);
}

TEST(MeshShadows, TooLittleMemoryAndNothingToThrowOneAreNoTrouble) {
  const NoProgress silent;
  const TriangleMesh above = sheet(5, 22, 30);
  EXPECT_THROW(MeshShadow({shadow_of(above, 1)}, {{}, {0, 0, 1}, 0, 4}, silent), Error);
  const MeshShadow none({}, {{}, {0, 0, 1}}, silent);
  EXPECT_EQ(none.passed({0, 0, 0}), 1);
  const MeshShadow edge_on({shadow_of(above, 1)}, {{}, {1, 0, 0}}, silent);
  EXPECT_EQ(edge_on.passed({0, 10, 30}), 1);
}

}  // namespace
}  // namespace octavo
