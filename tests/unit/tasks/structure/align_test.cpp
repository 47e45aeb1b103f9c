#include "octavo/tasks/structure/align.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "octavo/core/vectors.h"
#include "octavo/tasks/affine_file.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kStairSize = {48, 40, 36};

class Align : public testing::TaskFiles {
 protected:
  template <class Inside>
  static DenseMask solid(Inside inside) {
    DenseMask mask{kStairSize, std::vector<std::uint8_t>(48 * 40 * 36)};
    for_each_voxel(kStairSize, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
    return mask;
  }

  void SetUp() override {
    // Three bars of three lengths from a corner: nothing turns them onto themselves.
    bars_ = solid([](const Index3& p) {
      const bool is_x = p.x >= 4 && p.x < 44 && p.y >= 4 && p.y < 12 && p.z >= 4 && p.z < 9;
      const bool is_y = p.x >= 4 && p.x < 10 && p.y >= 4 && p.y < 34 && p.z >= 4 && p.z < 14;
      const bool is_z = p.x >= 4 && p.x < 13 && p.y >= 4 && p.y < 11 && p.z >= 4 && p.z < 26;
      return is_x || is_y || is_z;
    });
    geometry_ = {{3, -5, 8}, {0.5, 0.5, 0.6}};
    options_.fixed = write("fixed.8vo", bars_);
    options_.matrix = {folder_.file("pose.txt"), false};
  }

  DenseMask bars_;
  AlignOptions options_;
};

TEST_F(Align, FindsWhereTheGridWasMoved) {
  const Geometry fixed = geometry_;
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  geometry_.origin_mm = {100, 40, -20};
  geometry_.direction = {c, 0, s, 0, 1, 0, -s, 0, c};
  options_.moving = write("moving.8vo", bars_);
  const AlignResult result = align(options_, context_);
  ASSERT_TRUE(result.is_found);
  EXPECT_GT(result.pose.overlap, 0.95);
  const Affine map = read_affine(options_.matrix.path);
  for (const Point3& p : {Point3{4, 4, 4}, {44, 12, 9}, {10, 34, 14}, {13, 11, 26}}) {
    const Point3 made = map(geometry_.to_world(p));
    const Point3 expected = fixed.to_world(p);
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(made[a], expected[a], 0.25);
  }
}

TEST_F(Align, WritesNoMatrixWhereSurfacesDoNotMeet) {
  geometry_.spacing_mm = {8, 8, 8};
  options_.moving = write("speckles.8vo", solid([](const Index3& p) {
    return (p.x * 7 + p.y * 13 + p.z * 29) % 17 == 0;
  }));
  const AlignResult result = align(options_, context_);
  EXPECT_FALSE(result.is_found);
  EXPECT_FALSE(std::filesystem::exists(options_.matrix.path));
}

TEST_F(Align, FindsHalfOfTheBars) {
  DenseMask half = bars_;
  for_each_voxel(kStairSize, [&](const Index3& p) {
    if (p.x + p.y + p.z > 34) half.at(p) = 0;
  });
  options_.moving = write("half.8vo", half);
  options_.matrix.overwrite = true;
  for (int way = 0; way < 2; ++way) {
    ASSERT_TRUE(align(options_, context_).is_found);
    const Affine map = read_affine(options_.matrix.path);
    for (const Point3& p : {Point3{4, 4, 4}, {26, 12, 9}, {10, 24, 9}, {13, 11, 14}}) {
      const Point3 made = map(geometry_.to_world(p));
      const Point3 expected = geometry_.to_world(p);
      for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(made[a], expected[a], 0.25);
    }
    std::swap(options_.moving, options_.fixed);
  }
}

TEST_F(Align, FindsNoBallInACrowdOfSurfaces) {
  // Thin walls four voxels apart: something is near wherever a ball lies.
  options_.fixed = write("walls.8vo", solid([](const Index3& p) {
    return p.x % 8 < 4 || (p.y % 10 < 4 && p.z % 9 < 4);
  }));
  options_.moving = write("ball.8vo", solid([](const Index3& p) {
    const Index3 d = {p.x - 20, p.y - 18, p.z - 17};
    return d.x * d.x + d.y * d.y + d.z * d.z <= 100;
  }));
  const AlignResult result = align(options_, context_);
  EXPECT_GT(result.pose.overlap, 0.6);
  EXPECT_FALSE(result.is_found);
  EXPECT_FALSE(std::filesystem::exists(options_.matrix.path));
}

/// A body of five ellipsoids that nothing turns onto itself or its mirror image.
bool is_in_lumps(const Point3& from_middle) {
  struct Lump {
    Point3 middle;
    Point3 radius;
  };
  constexpr Lump kLumps[] = {{{0, 0, 0}, {18, 11, 8}},
                             {{12, 8, 0}, {6, 6, 10}},
                             {{-10, 2, 9}, {5, 7, 6}},
                             {{0, -12, -4}, {4, 9, 5}},
                             {{-14, -6, -6}, {6, 3, 4}}};
  for (const Lump& lump : kLumps) {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double share = (from_middle[a] - lump.middle[a]) / lump.radius[a];
      sum += share * share;
    }
    if (sum <= 1) return true;
  }
  return false;
}

bool is_in_lumps(const Index3& p, bool is_mirrored = false) {
  const double x = static_cast<double>(p.x) - 23.5;
  return is_in_lumps(Point3{is_mirrored ? -x : x, static_cast<double>(p.y) - 23,
                            static_cast<double>(p.z) - 16});
}

TEST_F(Align, LaysAWholeOntoItsHalfWithinHalfAVoxel) {
  geometry_ = {{0, 0, 0}, {1, 1, 1}};
  options_.fixed = write("half.8vo", solid([](const Index3& p) {
    return p.x > 21 && is_in_lumps(p);
  }));
  // Turned by 0.6 about z, and by 0.4 about x; around the middle of a larger grid.
  const std::array<Point3, 3> axes = {{{std::cos(0.6), std::sin(0.6), 0},
                                       {-std::sin(0.6) * std::cos(0.4),
                                        std::cos(0.6) * std::cos(0.4), std::sin(0.4)},
                                       {std::sin(0.6) * std::sin(0.4),
                                        -std::cos(0.6) * std::sin(0.4), std::cos(0.4)}}};
  const auto from_turned = [&](const Point3& p) {
    const Point3 d = {p[0] - 30.3, p[1] - 30.2, p[2] - 25.6};
    Point3 own{};
    for (std::size_t i = 0; i < 3; ++i) own[i] = dot(axes[i], d);
    return own;
  };
  DenseMask whole{{60, 60, 52}, std::vector<std::uint8_t>(60 * 60 * 52)};
  for_each_voxel(whole.size, [&](const Index3& p) {
    const Point3 place = {static_cast<double>(p.x), static_cast<double>(p.y),
                          static_cast<double>(p.z)};
    whole.at(p) = is_in_lumps(from_turned(place)) ? 1 : 0;
  });
  options_.moving = write("whole.8vo", whole);
  const AlignResult result = align(options_, context_);
  ASSERT_TRUE(result.is_found) << result.why_none;
  double largest = 0;
  for (const Point3& p : {Point3{10, 30, 20}, {50, 30, 20}, {30, 10, 40}, {30, 50, 30}}) {
    const Point3 own = from_turned(p);
    const Point3 apart = difference(result.pose.map(p), {own[0] + 23.5, own[1] + 23, own[2] + 16});
    largest = std::max(largest, std::sqrt(dot(apart, apart)));
  }
  EXPECT_LT(largest, 0.5);
}

TEST_F(Align, FindsNoPoseOfHalvesThatShareNothing) {
  geometry_.spacing_mm = {1, 1, 1};
  options_.moving = write("left.8vo", solid([](const Index3& p) {
    return p.x < 20 && is_in_lumps(p);
  }));
  options_.fixed = write("right.8vo", solid([](const Index3& p) {
    return p.x > 28 && is_in_lumps(p);
  }));
  const AlignResult result = align(options_, context_);
  EXPECT_FALSE(result.is_found) << result.agreement.sharpness;
  EXPECT_FALSE(result.why_none.empty());
  EXPECT_FALSE(std::filesystem::exists(options_.matrix.path));
}

TEST_F(Align, FindsNoPoseOfAMirrorImage) {
  geometry_.spacing_mm = {1, 1, 1};
  options_.moving = write("image.8vo", solid([](const Index3& p) { return is_in_lumps(p, true); }));
  options_.fixed = write("lumps.8vo", solid([](const Index3& p) { return is_in_lumps(p); }));
  const AlignResult result = align(options_, context_);
  // The largest of the lumps has no sides: it lies exactly where it should, and the others do not.
  EXPECT_FALSE(result.is_found) << result.agreement.parting;
  EXPECT_NE(result.why_none.find("on all sides"), std::string::npos) << result.why_none;
  EXPECT_FALSE(std::filesystem::exists(options_.matrix.path));
}

TEST_F(Align, WarnsOfBodiesThatAreMerelyAlike) {
  const auto blunt = [](double length) {
    return solid([=](const Index3& p) {
      const Point3 d = {(static_cast<double>(p.x) - 23.5) / length,
                        (static_cast<double>(p.y) - 19.5) / 14,
                        (static_cast<double>(p.z) - 17.5) / 11};
      return d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= 1;
    });
  };
  geometry_.spacing_mm = {1, 1, 1};
  options_.fixed = write("short.8vo", blunt(19));
  options_.moving = write("long.8vo", blunt(19.7));
  const AlignResult alike = align(options_, context_);
  EXPECT_TRUE(alike.is_found) << alike.why_none;
  EXPECT_TRUE(alike.is_doubtful) << alike.agreement.sharpness;
  EXPECT_EQ(warnings_.size(), 1u);
  warnings_.clear();
  options_.moving = write("again.8vo", blunt(19));
  options_.matrix.overwrite = true;
  EXPECT_FALSE(align(options_, context_).is_doubtful);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Align, SaysThatNothingHoldsABall) {
  geometry_.spacing_mm = {1, 1, 1};
  const auto ball = [](double radius) {
    return solid([=](const Index3& p) {
      const Point3 d = {static_cast<double>(p.x) - 23.7, static_cast<double>(p.y) - 19.6,
                        static_cast<double>(p.z) - 17.5};
      return d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= radius * radius;
    });
  };
  options_.moving = write("ball.8vo", ball(12));
  options_.fixed = options_.moving;
  options_.matrix = {};
  EXPECT_GT(align(options_, context_).pose.condition, 90);
  options_.moving = write("lumps.8vo", solid([](const Index3& p) { return is_in_lumps(p); }));
  options_.fixed = options_.moving;
  const AlignResult held = align(options_, context_);
  EXPECT_TRUE(held.is_found);
  EXPECT_LT(held.pose.condition, 25);
}

TEST_F(Align, WritesNoTextIntoAVolumesName) {
  options_.moving = write("moving.8vo", bars_);
  options_.matrix.path = folder_.file("pose.8vo");
  EXPECT_EQ(failure_of([&] { align(options_, context_); }).field, "matrix.path");
  EXPECT_FALSE(std::filesystem::exists(options_.matrix.path));
}

TEST_F(Align, NeedsSurfacesAndASpacing) {
  options_.moving = write("empty.8vo", solid([](const Index3&) { return false; }));
  EXPECT_EQ(failure_of([&] { align(options_, context_); }).kind, ErrorKind::invalid_argument);
  options_.moving = write("plain.8vo", bars_, false);
  EXPECT_EQ(failure_of([&] { align(options_, context_); }).kind, ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo
