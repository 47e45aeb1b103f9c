#include "octavo/ops/grid/rotation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace octavo {
namespace {

constexpr Point3 kGridAxes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

Point3 rotated(const Rotation& rotation, const Point3& p) {
  return Affine{rotation, {0, 0, 0}}(p);
}

TEST(Rotation, QuartersAboutAnAxisAreExactTurns) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int quarters : {-5, -1, 0, 1, 2, 3, 6}) {
      const Rotation rotation = rotation_about(kGridAxes[axis], 90.0 * quarters);
      EXPECT_EQ(as_turn(rotation), quarter_turns(axis, quarters));
      EXPECT_EQ(rotation, rotation_of(quarter_turns(axis, quarters)));
      // The same axis the other way round, of another length.
      Point3 reversed{};
      reversed[static_cast<std::size_t>(axis)] = -3;
      EXPECT_EQ(rotation_about(reversed, -90.0 * quarters), rotation);
    }
  }
}

TEST(Rotation, ItIsRightHandedAndKeepsLengths) {
  const Point3 turned = rotated(rotation_about({0, 0, 1}, 30), {1, 0, 0});
  EXPECT_NEAR(turned[0], std::sqrt(0.75), 1e-15);
  EXPECT_NEAR(turned[1], 0.5, 1e-15);
  const Point3 axes[] = {{1, 1, 0}, {-2, 0.5, 1e-3}, {1e-200, 2e-200, 0}, {1e300, 0, 1e300}};
  for (const Point3& axis : axes) {
    const Rotation rotation = rotation_about(axis, 77);
    const Point3 p = rotated(rotation, {3, -1, 2});
    EXPECT_NEAR(std::hypot(p[0], p[1], p[2]), std::sqrt(14.0), 1e-12);
    const Rotation none = chained(rotation, rotation_about(axis, 360 - 77));
    EXPECT_EQ(as_turn(none), AxisTurn{});
    EXPECT_EQ(as_turn(rotation), std::nullopt);
  }
}

TEST(Rotation, TheTurnedGridCoversTheVolumeAndNoMore) {
  const Geometry geometry{{-10, 4, 2}, {0.5, 0.75, 3}};
  const Size3 size{40, 21, 9};
  const Rotation rotation = rotation_about({0, 0, 1}, 30);
  const TurnedGrid grid = turned_grid(geometry, size, rotation, true);
  EXPECT_EQ(grid.size.z, 9);
  EXPECT_EQ(grid.to_source.linear[8], 1);
  const double wide = 20 * std::sqrt(0.75) + 15.75 * 0.5;
  const double high = 20 * 0.5 + 15.75 * std::sqrt(0.75);
  EXPECT_EQ(grid.size.x, static_cast<std::int64_t>(std::ceil(wide / 0.5)));
  EXPECT_EQ(grid.size.y, static_cast<std::int64_t>(std::ceil(high / 0.75)));
  // Nearer to a quarter turn the spacings change places.
  const TurnedGrid upright = turned_grid(geometry, size, rotation_about({1, 0, 0}, 80), true);
  EXPECT_EQ(upright.geometry.spacing_mm, (Point3{0.5, 3, 0.75}));
}

}  // namespace
}  // namespace octavo
