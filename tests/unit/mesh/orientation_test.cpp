#include "octavo/mesh/orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace octavo {
namespace {

TEST(Orientation, SaysOnWhichSideOfAPlaneAPointLies) {
  const Point3 a = {0, 0, 0};
  const Point3 b = {1, 0, 0};
  const Point3 c = {0, 1, 0};
  EXPECT_EQ(orientation_of(a, b, c, {0.3, 0.3, -1}), 1);
  EXPECT_EQ(orientation_of(a, b, c, {0.3, 0.3, 1}), -1);
  EXPECT_EQ(orientation_of(a, b, c, {7, -9, 0}), 0);
}

// Whole numbers of 20 bits, whose determinant 128-bit integers hold.
TEST(Orientation, IsThatOfExactArithmeticNextToThePlane) {
  std::mt19937 random(3);
  const auto number = [&] { return static_cast<std::int64_t>(random() % (1 << 20)); };
  for (int i = 0; i < 2000; ++i) {
    std::array<std::array<std::int64_t, 3>, 4> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = {number(), number(), number()};
    // Nearly in the plane of the others.
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p[3][axis] = (p[0][axis] + p[1][axis] + p[2][axis]) / 3 + (i % 3 == 0 ? number() % 2 : 0);
    }
    std::array<std::array<__int128, 3>, 3> d;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) d[k][axis] = p[k][axis] - p[3][axis];
    }
    const __int128 exact = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                           d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                           d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
    const auto place = [&](std::size_t k) {
      return Point3{static_cast<double>(p[k][0]), static_cast<double>(p[k][1]),
                    static_cast<double>(p[k][2])};
    };
    EXPECT_EQ(orientation_of(place(0), place(1), place(2), place(3)),
              exact > 0 ? 1 : exact < 0 ? -1 : 0);
  }
}

// Floats of very different sizes, so that differences of coordinates are rounded.
TEST(Orientation, IsZeroInAPlaneThroughTheOriginOnly) {
  const auto f = [](double value) { return static_cast<double>(static_cast<float>(value)); };
  const Point3 a = {f(1e6), f(0.1), 0};
  const Point3 b = {f(-0.3), f(7e5), 0};
  const Point3 c = {f(1e-7), f(-2e5), 0};
  EXPECT_EQ(orientation_of(a, b, c, {f(3.3), f(1e-6), 0}), 0);
  EXPECT_EQ(orientation_of(a, b, c, {f(3.3), f(1e-6), f(1e-30)}),
            -turn_of(a, b, c, 0, 1));
}

TEST(Orientation, IsZeroAcrossAnAxisFarFromTheOrigin) {
  const auto place = [](std::size_t axis, double u, double v) {
    Point3 point;
    point[axis] = 12345.678;
    point[(axis + 1) % 3] = u;
    point[(axis + 2) % 3] = v;
    return point;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(orientation_of(place(axis, 1e6, 0.1), place(axis, -0.3, 7e5), place(axis, 1e-7, -2),
                             place(axis, 3.3, 1e-6)),
              0);
    const int u = static_cast<int>((axis + 1) % 3);
    EXPECT_EQ(turn_of(place(axis, 1e6, 0.1), place(axis, -0.3, 7e5), place(axis, 3, 4),
                      static_cast<int>(axis), u),
              0);
  }
}

}  // namespace
}  // namespace octavo
