#include "octavo/render/rays/ray_shade.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>

#include "octavo/core/error.h"
#include "unit/render/rays/ray_scenes.h"

namespace octavo {
namespace {

using testing::CastScene;
using testing::cast_scene;
using testing::expect_levels_alike;
using testing::gathered;
using testing::noisy_ball;
using testing::RaySetup;

RayShade shade_of_matter(const Size3& size,
                         const std::function<bool(const Index3&)>& is_matter,
                         const Geometry& geometry = {}) {
  ExtinctionGrid grid{size, geometry, {}};
  visit_cells(box_of(size), {1, 1, 1}, [&](const Index3& cell) {
    grid.per_mm.push_back(is_matter(cell) ? 3.0f : 0.0f);
    return true;
  });
  const NoProgress silent;
  return RayShade(std::move(grid), silent);
}

TEST(RayShades, AHollowIsDarkerThanAPlane) {
  // A block up to z = 12 with a narrow shaft down its middle.
  const RayShade shade = shade_of_matter({33, 33, 33}, [](const Index3& cell) {
    const bool is_in_shaft = std::abs(cell.x - 16) <= 1 && std::abs(cell.y - 16) <= 1;
    return cell.z < 12 && !is_in_shaft;
  });
  const float plane = shade.ambient_at({6, 16, 12});
  EXPECT_GT(plane, 0.75f);
  EXPECT_LT(shade.ambient_at({16, 16, 4}), 0.4f * plane);
  EXPECT_LT(shade.ambient_at({16, 16, 4}), shade.ambient_at({16, 16, 10}));
  EXPECT_EQ(shade.ambient_at({16, 16, 30}), 1.0f);  // nothing is near
}

TEST(RayShades, AWallThrowsItsShadowAwayFromTheLamp) {
  // A floor, and a wall across x.
  RayShade shade = shade_of_matter({40, 40, 20}, [](const Index3& cell) {
    return cell.z < 2 || (cell.x >= 19 && cell.x < 22 && cell.z < 14);
  });
  const NoProgress silent;
  EXPECT_EQ(shade.direct_at({30, 20, 2}), 1.0f);
  shade.set_lamp({-0.7071, 0, 0.7071}, silent);
  EXPECT_GT(shade.direct_at({8, 20, 2}), 0.9f);
  EXPECT_LT(shade.direct_at({26, 20, 2}), 0.3f);
  // At places between cells, far from all matter and beside the grid as well.
  EXPECT_GT(shade.passed_to_lamp({8.3, 20.2, 2.4}), 0.9f);
  EXPECT_LT(shade.passed_to_lamp({26.4, 19.7, 2.2}), 0.2f);
  EXPECT_LT(shade.passed_to_lamp({29.5, 20, 3.5}), 0.2f);
  EXPECT_LT(shade.passed_to_lamp({42, 20, -7}), 0.2f);
  EXPECT_EQ(shade.passed_to_lamp({60, 20, 2}), 1.0f);
  shade.set_lamp({0.7071, 0, 0.7071}, silent);
  EXPECT_LT(shade.direct_at({14, 20, 2}), 0.3f);
  EXPECT_GT(shade.direct_at({34, 20, 2}), 0.9f);
}

TEST(RayShades, LongVoxelsAndTurnedAxesAreThoseOfTheWorld) {
  // The same wall, its x along the second axis of the world, every second z.
  Geometry turned;
  turned.spacing_mm = {1, 1, 2};
  turned.direction = {0, 1, 0, 1, 0, 0, 0, 0, -1};  // left-handed axes are as good
  RayShade shade = shade_of_matter(
      {40, 40, 10},
      [](const Index3& cell) {
        return cell.z >= 9 || (cell.x >= 19 && cell.x < 22 && cell.z >= 3);
      },
      turned);
  const NoProgress silent;
  shade.set_lamp({0, -0.7071, 0.7071}, silent);
  EXPECT_GT(shade.direct_at({8, 20, 8}), 0.9f);
  EXPECT_LT(shade.direct_at({26, 20, 8}), 0.3f);
}

TEST(RayShades, AllInstructionSetsGiveTheSameBitsAndLightIsNeverAdded) {
  const auto ball = noisy_ball(40);
  RayShade shade = shade_of_matter({21, 1, 19}, [](const Index3& cell) { return cell.x > 8; });
  const NoProgress silent;
  shade.set_lamp({0.6, 0, 0.8}, silent);
  for (const RayMode mode : {RayMode::volume, RayMode::iso}) {
    RaySetup setup;
    setup.mode = mode;
    setup.follow = follow_rays_portable;
    const CastScene bright = cast_scene(ball, setup);
    setup.shade = shade.table(ball.geometry, true);
    const CastScene portable = cast_scene(ball, setup);
    EXPECT_NE(gathered(portable.field), gathered(bright.field));
    expect_levels_alike(ball, setup, portable);
    const Picture lit = ray_picture(bright.field, {});
    const Picture shaded = ray_picture(portable.field, {});
    for (std::size_t i = 0; i < lit.pixels.size(); ++i) {
      ASSERT_LE(shaded.pixels[i], lit.pixels[i]);
    }
  }
}

TEST(RayShades, StopWhereTheWorkIsCancelled) {
  class Cancelled final : public Progress {
    void begin(std::string_view, std::int64_t, std::string_view) override {}
    void advance(std::int64_t) override {}
    void end() override {}
    bool is_cancelled() const override { return true; }
  };
  const Cancelled stopped;
  EXPECT_THROW(RayShade({{4, 4, 4}, {}, std::vector<float>(64, 1.0f)}, stopped), Error);
}

}  // namespace
}  // namespace octavo
