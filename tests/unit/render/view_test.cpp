#include "octavo/render/view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {
namespace {

constexpr Size3 kViewSize = {60, 50, 40};

View look(const Viewpoint& viewpoint, const Geometry& geometry = {}, const ViewFrame& frame = {}) {
  return make_view(geometry, kViewSize, box_of(kViewSize), viewpoint, frame);
}

Index3 corner_of_volume(int corner) {
  return {(corner & 1) * kViewSize.x, (corner >> 1 & 1) * kViewSize.y,
          (corner >> 2 & 1) * kViewSize.z};
}

TEST(View, LettersNameThePatientsSides) {
  const auto letters = [](const Viewpoint& viewpoint) { return edge_letters(look(viewpoint)); };
  EXPECT_EQ(letters(*find_viewpoint("front")), (EdgeLetters{"R", "L", "S", "I"}));
  EXPECT_EQ(letters(*find_viewpoint("back")), (EdgeLetters{"L", "R", "S", "I"}));
  EXPECT_EQ(letters(*find_viewpoint("left")), (EdgeLetters{"A", "P", "S", "I"}));
  EXPECT_EQ(letters(*find_viewpoint("right")), (EdgeLetters{"P", "A", "S", "I"}));
  EXPECT_EQ(letters(*find_viewpoint("top")), (EdgeLetters{"L", "R", "A", "P"}));
  EXPECT_EQ(letters(*find_viewpoint("bottom")), (EdgeLetters{"R", "L", "A", "P"}));
  EXPECT_EQ(letters(viewpoint_at(0, 0)), (EdgeLetters{"R", "L", "S", "I"}));
  EXPECT_EQ(letters(viewpoint_at(90, 0)), (EdgeLetters{"A", "P", "S", "I"}));
  EXPECT_EQ(letters(viewpoint_at(30, 0)), (EdgeLetters{"RA", "LP", "S", "I"}));
  EXPECT_EQ(letters(viewpoint_at(0, 40)), (EdgeLetters{"R", "L", "SP", "IA"}));
  EXPECT_FALSE(find_viewpoint("above"));
}

TEST(View, SidesCanBeJoined) {
  const double third = 1 / std::sqrt(3.0);
  const Viewpoint corner = *find_viewpoint("left-front-top");
  const Point3 expected = {third, -third, third};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(corner.toward[i], expected[i], 1e-12);
  EXPECT_EQ(find_viewpoint("top-front-left")->toward, corner.toward);
  EXPECT_NEAR(find_viewpoint("back-right")->toward[0], -std::sqrt(0.5), 1e-12);
  EXPECT_TRUE(find_viewpoint(kUsualViewpoint));
  for (const char* name : {"", "-", "left-", "-left", "left-left", "left-right", "left--top",
                           "left-front-top-left", "Left"}) {
    EXPECT_FALSE(find_viewpoint(name)) << name;
  }
}

/// All grids whose axes run along those of the body, over the same 60 x 50 x 40 mm.
std::vector<std::pair<Geometry, Size3>> upright_grids() {
  const Point3 lengths = {60, 50, 40};
  std::vector<std::pair<Geometry, Size3>> grids;
  std::array<std::size_t, 3> order = {0, 1, 2};
  do {
    for (int flips = 0; flips < 8; ++flips) {
      Geometry geometry;
      geometry.direction = {};
      geometry.spacing_mm = {1, 2, 2.5};
      Size3 size;
      Point3 corner = {-30, -25, -20};
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t world = order[a];
        const bool is_flipped = (flips >> a & 1) != 0;
        geometry.direction[3 * world + a] = is_flipped ? -1 : 1;
        size[static_cast<int>(a)] = std::lround(lengths[world] / geometry.spacing_mm[a]);
        const double half = geometry.spacing_mm[a] / 2;
        corner[world] += is_flipped ? lengths[world] - half : half;
      }
      geometry.origin_mm = corner;
      grids.push_back({geometry, size});
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return grids;
}

TEST(View, TheUsualViewIsThatOfThePatientWhateverTheGrid) {
  const auto grids = upright_grids();
  ASSERT_EQ(grids.size(), 48u);
  const Point3 landmarks[] = {{-21, 5, 3}, {14, -18, 9}, {0, 11, -17}};
  for (const char* side : {"left-front-top", "front", "right-back", "bottom"}) {
    std::vector<Point3> expected;
    for (const auto& [geometry, size] : grids) {
      const View view = make_view(geometry, size, box_of(size), *find_viewpoint(side), {});
      const double pixel = std::ldexp(1, view.fraction_bits);
      for (std::size_t i = 0; i < std::size(landmarks); ++i) {
        const Point3 index = geometry.to_index(landmarks[i]);
        Point3 spot = {static_cast<double>(view.origin.x), static_cast<double>(view.origin.y),
                       static_cast<double>(view.origin.depth)};
        for (std::size_t a = 0; a < 3; ++a) {
          // Corners of voxels are half a voxel before their middle.
          spot[0] += static_cast<double>(view.axes[a].x) * (index[a] + 0.5);
          spot[1] += static_cast<double>(view.axes[a].y) * (index[a] + 0.5);
          spot[2] += static_cast<double>(view.axes[a].depth) * (index[a] + 0.5);
        }
        if (expected.size() <= i) expected.push_back(spot);
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(spot[c] / pixel, expected[i][c] / pixel, 0.01);
      }
    }
    // Left is on the right of a picture from the front, and up is up.
    if (std::string(side) == "left-front-top") {
      EXPECT_GT(expected[1][0], expected[0][0]);
      EXPECT_LT(expected[1][1], expected[2][1]);
    }
  }
}

TEST(View, AxesPointToTheSidesThatAreSeen) {
  const auto names = [](const char* side) {
    const auto axes = patient_axes(look(*find_viewpoint(side)));
    return axes[0].name + axes[1].name + axes[2].name;
  };
  EXPECT_EQ(names("left-front-top"), "LAS");
  EXPECT_EQ(names("right-back-bottom"), "RPI");
  const auto axes = patient_axes(look(*find_viewpoint("left-front-top")));
  EXPECT_GT(axes[0].right, 0.5);   // left is to the right of the picture
  EXPECT_LT(axes[1].right, -0.5);  // the front to its left
  EXPECT_GT(axes[2].up, 0.7);
  for (const ViewAxis& axis : axes) EXPECT_NEAR(axis.toward, 1 / std::sqrt(3.0), 1e-9);

  EXPECT_TRUE(is_seen_from_a_side(look(*find_viewpoint("back"))));
  EXPECT_TRUE(is_seen_from_a_side(look(viewpoint_at(5, -8))));
  EXPECT_FALSE(is_seen_from_a_side(look(*find_viewpoint("left-front"))));
  EXPECT_FALSE(is_seen_from_a_side(look(viewpoint_at(0, 40))));

  Geometry geometry;
  geometry.direction = {0, 0, 1, -1, 0, 0, 0, 1, 0};  // x runs to the front, y up, z to the left
  const View view = look(*find_viewpoint("front"), geometry);
  const auto grid = grid_axes(view);
  EXPECT_EQ(grid[0].name, "x");
  EXPECT_NEAR(grid[0].toward, 1, 1e-6);
  EXPECT_NEAR(grid[1].up, 1, 1e-6);
  EXPECT_NEAR(grid[2].right, 1, 1e-6);
}

TEST(View, DirectionsAreStepsAlongTheAxesOfTheGrid) {
  Geometry geometry;
  geometry.spacing_mm = {1, 2, 5};
  geometry.direction = {0, 0, 1, -1, 0, 0, 0, 1, 0};  // x runs to the front, y up, z to the left
  const Viewpoint viewpoint = viewpoint_along(geometry, {1, 1, 1});
  const double length = std::sqrt(30.0);
  const Point3 expected = {5 / length, -1 / length, 2 / length};
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(viewpoint.toward[i], expected[i], 1e-12);
  EXPECT_EQ(edge_letters(look(viewpoint_along(geometry, {1, 0, 0}), geometry)),
            edge_letters(look(*find_viewpoint("front"))));
}

TEST(View, WhatIsAlongTheDirectionFallsOnOnePointAndComesNearer) {
  Geometry geometry;
  geometry.spacing_mm = {0.7, 1.3, 3};
  for (const Point3& steps : std::vector<Point3>{{1, 1, 1}, {-1, 1, 0}, {2, -3, 1}, {0, 0, -1}}) {
    const View view = look(viewpoint_along(geometry, steps), geometry);
    Place moved;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      moved = moved + view.axes[axis] * static_cast<std::int64_t>(steps[axis]);
      if (steps[axis] == 0) continue;
      EXPECT_EQ(view.nearness[axis], steps[axis] > 0 ? 1 : -1);
    }
    EXPECT_LE(std::abs(moved.x), 4);
    EXPECT_LE(std::abs(moved.y), 4);
    EXPECT_GT(moved.depth, 1000);
  }
}

TEST(View, VoxelsAreDrawnTrueInSize) {
  Geometry geometry;
  geometry.spacing_mm = {0.5, 1, 2};
  const View view = look(*find_viewpoint("front"), geometry);
  EXPECT_NEAR(static_cast<double>(view.axes[0].x) / static_cast<double>(-view.axes[2].y), 0.25,
              1e-4);
  EXPECT_EQ(view.axes[0].y, 0);
  const double pixel = std::ldexp(1, view.fraction_bits);
  EXPECT_NEAR(static_cast<double>(view.axes[0].x) / pixel, 0.5 / view.pixel_mm, 1e-4);
}

TEST(View, ShownBoxesFitAndFillThePicture) {
  ViewFrame frame;
  frame.width = 300;
  frame.height = 200;
  for (const double azimuth : {0.0, 33.0, 145.0, 290.0}) {
    const View view = look(viewpoint_at(azimuth, 20), {}, frame);
    const double pixel = std::ldexp(1, view.fraction_bits);
    double width = 0;
    double height = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Place place = view.place_of(corner_of_volume(corner));
      width = std::max(width, std::abs(static_cast<double>(place.x) / pixel - 150) * 2);
      height = std::max(height, std::abs(static_cast<double>(place.y) / pixel - 100) * 2);
    }
    EXPECT_LE(width, 300);
    EXPECT_LE(height, 200);
    EXPECT_TRUE(width > 260 || height > 170);
  }
}

TEST(View, ZoomEnlargesAroundTheMiddle) {
  ViewFrame frame;
  const View plain = look(viewpoint_at(20, 10), {}, frame);
  frame.zoom = 4;
  const View large = look(viewpoint_at(20, 10), {}, frame);
  EXPECT_NEAR(plain.pixel_mm, 4 * large.pixel_mm, 1e-12);
  const Place middle = large.place_of({kViewSize.x / 2, kViewSize.y / 2, kViewSize.z / 2});
  EXPECT_NEAR(std::ldexp(static_cast<double>(middle.x), -large.fraction_bits), 512, 0.01);
  EXPECT_NEAR(std::ldexp(static_cast<double>(middle.y), -large.fraction_bits), 512, 0.01);
}

TEST(View, ATurnGoesAroundThePatient) {
  const Viewpoint front = viewpoint_at(0, 15);
  for (const double degrees : {0.0, 60.0, 200.0}) {
    const Viewpoint found = turned(front, degrees);
    const Viewpoint expected = viewpoint_at(degrees, 15);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(found.toward[i], expected.toward[i], 1e-12);
      EXPECT_NEAR(found.up[i], expected.up[i], 1e-12);
    }
  }
}

TEST(View, NumbersStayBelowTheirBound) {
  for (const double zoom : {1e-3, 1.0, 50.0, 1e4}) {
    ViewFrame frame;
    frame.zoom = zoom;
    const View view = look(viewpoint_at(77, -31), {}, frame);
    EXPECT_GE(view.fraction_bits, 1);
    for (int corner = 0; corner < 8; ++corner) {
      const Place place = view.place_of(corner_of_volume(corner));
      EXPECT_LT(std::abs(place.x), 1 << 30);
      EXPECT_LT(std::abs(place.y), 1 << 30);
      EXPECT_LT(std::abs(place.depth), 1 << 30);
    }
  }
}

TEST(View, WhatCannotBeDrawnIsRejected) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(viewpoint_along({}, {0, 0, 0}), Error);
  EXPECT_THROW(viewpoint_along({}, {kNaN, 0, 1}), Error);
  EXPECT_THROW(viewpoint_at(kNaN, 0), Error);
  const auto rejects = [](const ViewFrame& frame) {
    EXPECT_THROW(look(viewpoint_at(0, 0), {}, frame), Error);
  };
  rejects({0, 10, 1, {}});
  rejects({10, ViewFrame::kLongestSide + 1, 1, {}});
  rejects({10, 10, 0, {}});
  rejects({10, 10, kNaN, {}});
  rejects({10, 10, 1, -1.0});
  rejects({10, 10, 1e9, {}});
}

}  // namespace
}  // namespace octavo
