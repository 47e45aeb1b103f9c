#include "octavo/render/cubes/cube_picture.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "octavo/ops/mask/shell.h"
#include "octavo/render/cubes/face_raster.h"
#include "support/dense_mask.h"
#include "support/read_png.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::pixel;

constexpr Color kBackground = {9, 8, 7};

struct Shot {
  std::vector<MaskTree> trees;
  std::vector<Color> colors;
  View view;
  CubeStyle style;
};

std::vector<PaintedMask> painted(const Shot& shot) {
  std::vector<PaintedMask> masks;
  for (std::size_t i = 0; i < shot.trees.size(); ++i) {
    masks.push_back({&shot.trees[i], shot.colors[i]});
  }
  return masks;
}

Picture drawn(const Shot& shot) { return draw_cubes(painted(shot), shot.view, shot.style); }

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Viewpoint random_viewpoint(const Geometry& geometry, std::mt19937& random) {
  if (random() % 2 == 0) return viewpoint_at(uniform(random, 0, 360), uniform(random, -90, 90));
  const auto step = [&] { return static_cast<double>(random() % 5) - 2; };
  Point3 steps = {step(), step(), step()};
  if (steps == Point3{}) steps = {1, 1, 1};
  return viewpoint_along(geometry, steps);
}

/// Masks side by side, of any spacing and turn, from any side.
Shot random_shot(const Size3& size, std::mt19937& random) {
  Shot shot;
  const DenseMask all = testing::random_mask(size, random);
  const DenseMask split = testing::random_mask(size, random);
  for (std::uint8_t part = 0; part < 2; ++part) {
    DenseMask one = all;
    testing::for_each_voxel(size, [&](const Index3& p) { one.at(p) &= split.at(p) == part; });
    shot.trees.push_back(testing::tree_of(one));
  }
  shot.colors = {{250, 120, 60}, {80, 200, 255}};
  Geometry geometry;
  geometry.spacing_mm = {uniform(random, 0.3, 1), uniform(random, 0.3, 1), uniform(random, 0.3, 3)};
  if (random() % 3 == 0) geometry.direction = {0, 0.8, 0.6, -1, 0, 0, 0, 0.6, -0.8};
  ViewFrame frame;
  frame.width = 40 + static_cast<std::int64_t>(random() % 90);
  frame.height = 40 + static_cast<std::int64_t>(random() % 90);
  frame.zoom = uniform(random, 0.2, 5);
  shot.view = make_view(geometry, size, box_of(size), random_viewpoint(geometry, random), frame);
  shot.style = {kBackground, 0, box_of(size)};
  return shot;
}

/// The side of a line on which a point lies that was moved to the right by very little and down by
/// far less: never 0.
int side_of(const PlanePoint& from, const PlanePoint& edge, const PlanePoint& point) {
  const std::int64_t cross = edge.x * (point.y - from.y) - edge.y * (point.x - from.x);
  if (cross != 0) return cross > 0 ? 1 : -1;
  if (edge.y != 0) return edge.y > 0 ? -1 : 1;
  return edge.x > 0 ? 1 : -1;
}

/// Whether a point lies in the parallelogram of two edges.
bool is_inside(const PlanePoint& corner, const PlanePoint& a, const PlanePoint& b,
               const PlanePoint& point) {
  const int turn = a.x * b.y - a.y * b.x > 0 ? 1 : -1;
  const PlanePoint beyond_a{corner.x + a.x, corner.y + a.y};
  const PlanePoint beyond_b{corner.x + b.x, corner.y + b.y};
  return side_of(corner, a, point) == turn && side_of(beyond_b, a, point) == -turn &&
         side_of(corner, b, point) == -turn && side_of(beyond_a, b, point) == turn;
}

/// What a pixel shows, found voxel by voxel: which mask, and the face's axis.
struct Seen {
  int mask = -1;
  int axis = -1;
  bool operator==(const Seen&) const = default;
};

Seen seen_at(const Shot& shot, const std::vector<DenseMask>& masks, std::int64_t x,
             std::int64_t y) {
  const View& view = shot.view;
  const std::int64_t half = std::int64_t{1} << (view.fraction_bits - 1);
  const PlanePoint point{(x << view.fraction_bits) + half, (y << view.fraction_bits) + half};
  Seen seen;
  std::int64_t nearest = 0;
  testing::for_each_voxel(masks.front().size, [&](const Index3& p) {
    for (int mask = 0; mask < static_cast<int>(masks.size()); ++mask) {
      if (masks[static_cast<std::size_t>(mask)].at(p) == 0) continue;
      const std::int64_t near =
          p.x * view.nearness[0] + p.y * view.nearness[1] + p.z * view.nearness[2];
      if (seen.mask >= 0 && near <= nearest) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        if (view.nearness[a] == 0) continue;
        Index3 corner = p;
        if (view.nearness[a] > 0) ++corner[axis];
        const Place at = view.place_of(corner);
        const Place& b = view.axes[(a + 1) % 3];
        const Place& c = view.axes[(a + 2) % 3];
        if (!is_inside({at.x, at.y}, {b.x, b.y}, {c.x, c.y}, point)) continue;
        seen = {mask, axis};
        nearest = near;
      }
    }
  });
  return seen;
}

TEST(CubePicture, EveryPixelShowsTheNearestVoxelThatItsCenterMeets) {
  std::mt19937 random(11);
  for (int round = 0; round < 12; ++round) {
    const Size3 size = round % 3 == 0 ? Size3{5, 3, 7} : Size3{9, 8, 6};
    const Shot shot = random_shot(size, random);
    std::vector<DenseMask> masks;
    for (const MaskTree& tree : shot.trees) masks.push_back(testing::dense_of(tree));
    const Picture picture = drawn(shot);
    // One mask and axis, one color, and the other way round.
    std::map<std::pair<int, int>, Color> color_of;
    std::set<Color> colors;
    for (std::int64_t y = 0; y < picture.height; ++y) {
      for (std::int64_t x = 0; x < picture.width; ++x) {
        const Seen seen = seen_at(shot, masks, x, y);
        const Color found = pixel(picture, x, y);
        if (seen.mask < 0) {
          ASSERT_EQ(found, kBackground);
          continue;
        }
        ASSERT_NE(found, kBackground);
        const auto [known, is_new] = color_of.try_emplace({seen.mask, seen.axis}, found);
        ASSERT_EQ(known->second, found) << "round " << round << " at " << x << ", " << y;
        colors.insert(found);
      }
    }
    EXPECT_LE(colors.size(), color_of.size());
  }
}

TEST(CubePicture, SurfaceLeavesGiveTheSamePicturePixelForPixel) {
  std::mt19937 random(12);
  for (int round = 0; round < 40; ++round) {
    const auto& sizes = testing::odd_sizes();
    Shot shot = random_shot(sizes[static_cast<std::size_t>(round) % sizes.size()], random);
    shot.style.fade = round % 2 == 0 ? 0.6 : 0;
    const Picture cubes = drawn(shot);
    for (MaskTree& tree : shot.trees) tree = shell(tree);
    ASSERT_EQ(drawn(shot).pixels, cubes.pixels) << "round " << round;
    ASSERT_EQ(draw_nearest_cubes(painted(shot), shot.view, shot.style).pixels, cubes.pixels)
        << "round " << round;
  }
}

TEST(CubePicture, TheNearestFirstGiveTheSamePicturePixelForPixel) {
  std::mt19937 random(14);
  for (int round = 0; round < 40; ++round) {
    const Size3 size = round % 2 == 0 ? Size3{70, 66, 80} : Size3{33, 9, 5};
    Shot shot = random_shot(size, random);
    shot.style.fade = 0.5;
    ASSERT_EQ(draw_nearest_cubes(painted(shot), shot.view, shot.style).pixels, drawn(shot).pixels)
        << "round " << round;
  }
}

TEST(CubePicture, ThreadsDoNotChangeThePicture) {
  std::mt19937 random(13);
  for (int round = 0; round < 6; ++round) {
    Shot shot = random_shot({70, 70, 70}, random);
    shot.style.fade = 0.5;
    Picture one;
    tbb::task_arena(1).execute([&] { one = drawn(shot); });
    for (const int threads : {2, 3, 7}) {
      Picture many;
      tbb::task_arena(threads).execute([&] { many = drawn(shot); });
      ASSERT_EQ(many.pixels, one.pixels);
    }
  }
}

TEST(CubePicture, ACubeHasThreeShades) {
  Shot shot;
  shot.trees = {box_mask({8, 8, 8}, {{2, 2, 2}, {6, 6, 6}})};
  shot.colors = {{200, 200, 200}};
  shot.style = {kBackground, 0, {{0, 0, 0}, {8, 8, 8}}};
  const auto shades = [&](const Viewpoint& viewpoint) {
    shot.view = make_view({}, {8, 8, 8}, shot.style.shown, viewpoint, {64, 64, 1, {}});
    const Picture picture = drawn(shot);
    std::set<Color> colors;
    for (std::int64_t i = 0; i < 64 * 64; ++i) colors.insert(pixel(picture, i % 64, i / 64));
    colors.erase(kBackground);
    return colors;
  };
  EXPECT_EQ(shades(viewpoint_along({}, {1, 1, 1})).size(), 3u);
  EXPECT_EQ(shades(viewpoint_along({}, {-1, 1, -1})).size(), 3u);
  EXPECT_EQ(shades(*find_viewpoint("front")).size(), 1u);
  EXPECT_EQ(shades(viewpoint_at(30, 0)).size(), 2u);
}

TEST(CubePicture, FadingDarkensWhatIsFar) {
  Shot shot;
  shot.trees = {box_mask({40, 4, 4}, {{0, 0, 0}, {2, 2, 2}}),
                box_mask({40, 4, 4}, {{38, 0, 2}, {40, 2, 4}})};
  shot.colors = {{200, 200, 200}, {200, 200, 200}};
  shot.style = {{0, 0, 0}, 0.5, {{0, 0, 0}, {40, 4, 4}}};
  shot.view = make_view({}, {40, 4, 4}, shot.style.shown, *find_viewpoint("left"), {40, 40, 1, {}});
  const Picture picture = drawn(shot);
  int maximum = 0;
  int minimum = 255;
  for (const std::uint8_t value : picture.pixels) {
    if (value == 0) continue;
    maximum = std::max<int>(maximum, value);
    minimum = std::min<int>(minimum, value);
  }
  EXPECT_NEAR(static_cast<double>(minimum) / maximum, 0.5 + 0.5 * 2 / 40, 0.02);
}

/// A line of voxels through space.
MaskTree needle_mask(const Size3& size, const Index3& from, const Index3& to) {
  DenseMask needle{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  constexpr int kSteps = 1000;
  for (int i = 0; i <= kSteps; ++i) {
    const auto at = [&](std::int64_t a, std::int64_t b) {
      return a + std::llround(static_cast<double>(b - a) * i / kSteps);
    };
    needle.at({at(from.x, to.x), at(from.y, to.y), at(from.z, to.z)}) = 1;
  }
  return testing::tree_of(needle);
}

/// Pixels that hang together with the first one that is not background, also over corners; -1 where
/// others do not.
std::int64_t hanging_together(const Picture& picture) {
  std::set<std::pair<std::int64_t, std::int64_t>> left;
  for (std::int64_t y = 0; y < picture.height; ++y) {
    for (std::int64_t x = 0; x < picture.width; ++x) {
      if (pixel(picture, x, y) != kBackground) left.insert({x, y});
    }
  }
  std::vector<std::pair<std::int64_t, std::int64_t>> reached;
  if (!left.empty()) reached.push_back(*left.begin());
  left.erase(left.begin(), left.empty() ? left.end() : std::next(left.begin()));
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (std::int64_t n = 0; n < 9; ++n) {
      const std::pair beside{reached[i].first + n % 3 - 1, reached[i].second + n / 3 - 1};
      if (left.erase(beside) > 0) reached.push_back(beside);
    }
  }
  return left.empty() ? static_cast<std::int64_t>(reached.size()) : -1;
}

TEST(CubePicture, WhatIsThinnerThanAPixelIsALineWithoutGaps) {
  std::mt19937 random(29);
  const Size3 size{70, 66, 68};
  Geometry geometry;
  for (const Point3& spacing : {Point3{1, 1, 1}, Point3{0.01, 0.02, 4}}) {
    geometry.spacing_mm = spacing;
    const std::int64_t side = spacing[2] == 1 ? 30 : 300;
    for (int round = 0; round < 30; ++round) {
      const auto any = [&](std::int64_t end) {
        return std::uniform_int_distribution<std::int64_t>(0, end - 1)(random);
      };
      const Index3 from{any(70), any(66), any(68)};
      const Index3 to{any(70), any(66), any(68)};
      Shot shot;
      shot.trees = {needle_mask(size, from, to)};
      shot.colors = {{200, 200, 200}};
      shot.style = {kBackground, 0, box_of(size), true};
      shot.view = make_view(geometry, size, box_of(size), random_viewpoint(geometry, random),
                            {side, side, 1, {}});
      const Picture picture = drawn(shot);
      const std::int64_t pixels = hanging_together(picture);
      EXPECT_GT(pixels, 0);
      // It is about as long as between its ends.
      const Place ends = shot.view.axes[0] * (to.x - from.x) + shot.view.axes[1] * (to.y - from.y) +
                         shot.view.axes[2] * (to.z - from.z);
      const double long_side =
          std::ldexp(static_cast<double>(std::max(std::abs(ends.x), std::abs(ends.y))),
                     -shot.view.fraction_bits);
      EXPECT_GE(static_cast<double>(pixels), long_side - 1);
      // One pixel wide, two where it goes down a step; long voxels are wide from above.
      if (side == 30) {
        EXPECT_LE(static_cast<double>(pixels), 2.5 * long_side + 9);
      }
      const Picture nearest = draw_nearest_cubes(painted(shot), shot.view, shot.style);
      EXPECT_EQ(nearest.pixels, picture.pixels);
    }
  }
}

TEST(CubePicture, WhatIsWiderThanAPixelLooksTheSameWhereThinThingsAreKept) {
  std::mt19937 random(31);
  for (int round = 0; round < 10; ++round) {
    Shot shot = random_shot({70, 70, 70}, random);
    shot.view = make_view({}, {70, 70, 70}, shot.style.shown, viewpoint_along({}, {1, -2, 3}),
                          {160, 160, 1, 1 / 1.5});
    const Picture picture = drawn(shot);
    shot.style.keeps_thin = true;
    EXPECT_EQ(drawn(shot).pixels, picture.pixels);
  }
}

/// A ball with a hole through it and a grain beside it.
Shot golden_shot() {
  const Size3 size{24, 24, 16};
  DenseMask ball{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  DenseMask grain = ball;
  testing::for_each_voxel(size, [&](const Index3& p) {
    const auto square = [](std::int64_t a) { return a * a; };
    const bool is_ball = square(2 * p.x - 23) + square(2 * p.y - 23) + square(3 * p.z - 23) < 400;
    const bool is_hole = square(2 * p.x - 23) + square(2 * p.y - 23) < 60;
    ball.at(p) = is_ball && !is_hole ? 1 : 0;
    grain.at(p) = p.x >= 20 && p.y >= 20 && p.z < 4 ? 1 : 0;
  });
  Shot shot;
  shot.trees = {testing::tree_of(ball), testing::tree_of(grain)};
  shot.colors = {{244, 232, 206}, {230, 90, 60}};
  shot.style = {{20, 24, 40}, 0.5, box_of(size)};
  Geometry geometry;
  geometry.spacing_mm = {1, 1, 1.5};
  shot.view = make_view(geometry, size, box_of(size), viewpoint_along(geometry, {1, 1, 1}),
                        {48, 40, 1, {}});
  return shot;
}

TEST(CubePicture, LooksLikeTheKeptPicture) {
  const Picture picture = drawn(golden_shot());
  const std::filesystem::path kept =
      std::filesystem::path(testing::source_folder()) / "tests/unit/render/golden/cubes.png";
  std::ifstream in(kept, std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(in), {}};
  const Picture expected = testing::read_png(bytes);
  ASSERT_EQ(expected.width, picture.width);
  ASSERT_EQ(expected.height, picture.height);
  // A pixel at an outline may fall to the other side on another machine; no more than that.
  std::int64_t far = 0;
  double sum = 0;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const int off = std::abs(int{picture.pixels[i]} - int{expected.pixels[i]});
    sum += off;
    far += off > 8 ? 1 : 0;
  }
  const auto count = static_cast<double>(picture.pixels.size());
  EXPECT_LT(static_cast<double>(far), 0.01 * count);
  EXPECT_LT(sum / count, 0.5);
}

}  // namespace
}  // namespace octavo
