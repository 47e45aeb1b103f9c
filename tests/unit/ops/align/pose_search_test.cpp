#include "octavo/ops/align/pose_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "octavo/core/vectors.h"
#include "octavo/ops/align/surface_points.h"
#include "octavo/ops/distance/distance_passes.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kHeadSize = {56, 64, 48};
const Geometry kHeadGeometry{{-30, 12, 7}, {1, 1, 1.5}};

/// Something like a head: nothing turns it onto itself.
MaskTree head() {
  DenseMask mask{kHeadSize,
                 std::vector<std::uint8_t>(static_cast<std::size_t>(kHeadSize.voxel_count()))};
  const auto is_in_ball = [](const Index3& p, const Point3& c, const Point3& r) {
    const double x = (static_cast<double>(p.x) - c[0]) / r[0];
    const double y = (static_cast<double>(p.y) - c[1]) / r[1];
    const double z = (static_cast<double>(p.z) - c[2]) / r[2];
    return x * x + y * y + z * z <= 1;
  };
  for_each_voxel(kHeadSize, [&](const Index3& p) {
    const bool is_in = (is_in_ball(p, {28, 34, 24}, {20, 26, 14}) &&
                        !is_in_ball(p, {28, 36, 26}, {15, 20, 10})) ||
                       is_in_ball(p, {26, 8, 20}, {4, 6, 5}) ||
                       is_in_ball(p, {50, 30, 16}, {5, 4, 9});
    mask.at(p) = is_in ? 1 : 0;
  });
  return testing::tree_of(mask);
}

class PoseSearch : public ::testing::Test {
 protected:
  PoseSearch()
      : mask_(head()),
        mm_(signed_distances(mask_, {DistanceTo::faces, kHeadGeometry.spacing_mm}, progress_)),
        coarse_(mm_, kHeadSize, kHeadGeometry, 2),
        fine_(mm_, kHeadSize, kHeadGeometry, 1),
        points_(surface_points(mask_, kHeadGeometry, 4000)) {}

  FoundPose found(const std::vector<Point3>& points, bool has_scale) {
    const PointSpread spread = spread_of(points_);
    return find_pose(points,
                     {coarse_, fine_, spread.middle, spread.axes, spread.radius_mm, 1.14},
                     has_scale, progress_);
  }

  /// How far points of the head are from where they belong, at most.
  double error_of(const FoundPose& pose, const Affine& moved) const {
    double largest = 0;
    for (const Point3& p : points_) {
      const Point3 d = difference(pose.map(moved(p)), p);
      largest = std::max(largest, std::sqrt(dot(d, d)));
    }
    return largest;
  }

  Affine random_map(std::mt19937& random, double scale) const {
    std::normal_distribution<double> normal;
    const Point3 a = unit({normal(random), normal(random), normal(random)});
    const Point3 b = unit(cross(a, {normal(random), normal(random), normal(random)}));
    const Point3 c = cross(a, b);
    Affine map;
    map.linear = {a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]};
    for (double& entry : map.linear) entry *= scale;
    map.offset = {50 * normal(random), 50 * normal(random), 50 * normal(random)};
    return map;
  }

  std::vector<Point3> moved_points(const Affine& map, bool is_half) const {
    std::vector<Point3> points;
    for (const Point3& p : points_) {
      if (!is_half || p[1] < 44) points.push_back(map(p));
    }
    return points;
  }

  NoProgress progress_;
  MaskTree mask_;
  std::vector<float> mm_;
  DistanceGrid coarse_;
  DistanceGrid fine_;
  std::vector<Point3> points_;
};

TEST_F(PoseSearch, FindsRandomPosesWithinHalfAVoxel) {
  std::mt19937 random(25);
  for (int i = 0; i < 3; ++i) {
    const Affine map = random_map(random, 1);
    const FoundPose pose = found(moved_points(map, false), false);
    EXPECT_LT(error_of(pose, map), 0.5);
    EXPECT_GT(pose.overlap, 0.95);
    EXPECT_LT(pose.mean_mm, 0.5);
    EXPECT_GT(pose.iterations, 0);
    EXPECT_LT(pose.condition, 1e4);
  }
}

TEST_F(PoseSearch, FindsHalfOfAHead) {
  std::mt19937 random(6);
  const Affine map = random_map(random, 1);
  EXPECT_LT(error_of(found(moved_points(map, true), false), map), 0.5);
}

TEST_F(PoseSearch, SettlesByPointsThatHaveACounterpart) {
  std::mt19937 random(9);
  const Affine map = random_map(random, 1);
  const std::vector<Point3> facing = moved_points(map, false);
  // A plane across the head that it does not have, as a cut has: it draws the pose aside.
  std::vector<Point3> points = facing;
  std::uniform_real_distribution<double> place(-20, 20);
  for (int i = 0; i < 3000; ++i) points.push_back(map({place(random), 47, 30 + place(random)}));
  FoundPose off;
  const auto back = inverse(map);
  ASSERT_TRUE(back);
  off.map = *back;
  off.map.offset[0] += 0.9;
  off.map.offset[2] -= 0.8;
  const PointSpread spread = spread_of(points_);
  const FoundPose pose =
      settled_pose(off, points, facing,
                   {coarse_, fine_, spread.middle, spread.axes, spread.radius_mm, 1.14}, false);
  EXPECT_GT(error_of(off, map), 1);
  EXPECT_LT(error_of(pose, map), 0.1);
  EXPECT_GT(pose.iterations, 0);
  EXPECT_LT(pose.overlap, 0.9);
  EXPECT_GT(pose.overlap, 0.5);
}

TEST_F(PoseSearch, DescribesAPoseThatNothingFaces) {
  std::mt19937 random(9);
  const Affine map = random_map(random, 1);
  const auto back = inverse(map);
  ASSERT_TRUE(back);
  FoundPose known;
  known.map = *back;
  known.iterations = 3;
  const PointSpread spread = spread_of(points_);
  const FoundPose pose =
      settled_pose(known, moved_points(map, false), {},
                   {coarse_, fine_, spread.middle, spread.axes, spread.radius_mm, 1.14}, false);
  EXPECT_LT(error_of(pose, map), 1e-6);
  EXPECT_EQ(pose.iterations, 3);
  EXPECT_GT(pose.overlap, 0.95);
  EXPECT_GT(pose.p95_mm, pose.mean_mm);
  EXPECT_GT(pose.condition, 1);
}

TEST_F(PoseSearch, FindsTheScaleAsWell) {
  std::mt19937 random(7);
  const Affine map = random_map(random, 1.3);
  const FoundPose pose = found(moved_points(map, false), true);
  EXPECT_LT(error_of(pose, map), 0.5);
  EXPECT_NEAR(pose.scale, 1 / 1.3, 0.01);
}

TEST_F(PoseSearch, DistancesGrowAsTheirSlopeSays) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-40, 120);
  for (int i = 0; i < 300; ++i) {
    const Point3 p = {place(random), place(random), place(random)};
    const GridDistance here = fine_.at(p);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      constexpr double kStep = 1e-5;
      Point3 q = p;
      q[axis] += kStep;
      EXPECT_NEAR((fine_.at(q).mm - here.mm) / kStep, here.slope[axis], 0.02);
    }
  }
}

}  // namespace
}  // namespace octavo
