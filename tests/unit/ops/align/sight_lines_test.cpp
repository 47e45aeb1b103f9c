#include "octavo/ops/align/sight_lines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "octavo/core/vectors.h"
#include "octavo/ops/align/pose_search.h"
#include "octavo/ops/align/surface_points.h"
#include "octavo/ops/distance/distance_passes.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kSightSize = {48, 40, 36};
const Geometry kSightGeometry{{5, -3, 2}, {1, 1, 1}};

class SightLines : public ::testing::Test {
 protected:
  template <class Inside>
  void take(Inside inside) {
    DenseMask mask{kSightSize,
                   std::vector<std::uint8_t>(static_cast<std::size_t>(kSightSize.voxel_count()))};
    for_each_voxel(kSightSize, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
    tree_ = testing::tree_of(mask);
    mm_ = signed_distances(tree_, {DistanceTo::faces, kSightGeometry.spacing_mm}, progress_);
  }

  NoProgress progress_;
  MaskTree tree_;
  std::vector<float> mm_;
};

TEST_F(SightLines, TheSmallestDistanceIsThatOfTheBallTheyPass) {
  take([](const Index3& p) {
    const Index3 d = {p.x - 24, p.y - 20, p.z - 18};
    return d.x * d.x + d.y * d.y + d.z * d.z <= 100;
  });
  const DistanceGrid grid(mm_, kSightSize, kSightGeometry, 1);
  const Point3 middle = kSightGeometry.to_world({24, 20, 18});
  const SightReach reach = {middle, 22};
  for (int i = 0; i < 24; ++i) {
    const double angle = i * std::numbers::pi / 12;
    const Point3 along = {std::cos(angle), std::sin(angle), 0.3};
    const Point3 beside = unit(cross(along, {0, 0, 1}));
    for (const double mm : {5.0, 10.0, 14.0}) {
      const Point3 place = sum(middle, scaled(beside, mm));
      const SightLine line = {difference(place, scaled(along, 900)), sum(place, along)};
      const NearestSight near = nearest_sight(grid, line, reach);
      EXPECT_NEAR(near.distance.mm, mm - 10, 0.8) << i << " " << mm;
    }
  }
}

TEST_F(SightLines, TheirMiddleIsWhereTheyCross) {
  std::vector<SightLine> lines;
  for (const Point3& from : {Point3{500, 0, 0}, {0, 400, 0}}) {
    for (int i = -5; i <= 5; ++i) lines.push_back({from, {7.0 * i / 5 + 20, -3, 4.0 * i}});
  }
  const SightMiddle crossing = middle_of(lines);
  EXPECT_NEAR(crossing.middle[0], 20, 3);
  EXPECT_NEAR(crossing.middle[1], -3, 3);
  EXPECT_NEAR(crossing.middle[2], 0, 3);
  EXPECT_GT(crossing.hold, 0.3);
  lines.resize(11);
  EXPECT_LT(middle_of(lines).hold, 0.01);
}

TEST_F(SightLines, OutlinesFromTwoSidesHoldAPose) {
  // Three balls that nothing turns onto themselves, whose outlines are known.
  const std::vector<std::pair<Point3, double>> balls = {
      {{15, 14, 12}, 9}, {{33, 20, 15}, 7}, {{20, 30, 25}, 5}};
  take([&](const Index3& p) {
    for (const auto& [middle, radius] : balls) {
      const Point3 d = {static_cast<double>(p.x) - middle[0], static_cast<double>(p.y) - middle[1],
                        static_cast<double>(p.z) - middle[2]};
      if (dot(d, d) <= radius * radius) return true;
    }
    return false;
  });
  // Lines that touch one ball and meet no other, moved away.
  const Point3 shift = {200, -150, 80};
  std::vector<SightLine> lines;
  for (const Point3& from : {Point3{600, 10, 30}, {-20, 500, 0}, {30, 100, 700}}) {
    for (std::size_t own = 0; own < balls.size(); ++own) {
      const Point3 middle = kSightGeometry.to_world(balls[own].first);
      const Point3 across = unit(cross(difference(middle, from), {0.2, 0.3, 0.9}));
      const Point3 upward = unit(cross(difference(middle, from), across));
      for (int i = 0; i < 48; ++i) {
        const double angle = i * std::numbers::pi / 24;
        const Point3 to = sum(middle, scaled(sum(scaled(across, std::cos(angle)),
                                                 scaled(upward, std::sin(angle))),
                                             balls[own].second));
        bool is_free = true;
        for (std::size_t other = 0; other < balls.size(); ++other) {
          const Point3 apart = difference(kSightGeometry.to_world(balls[other].first), from);
          const Point3 way = cross(apart, unit(difference(to, from)));
          if (other != own && dot(way, way) < std::pow(balls[other].second + 1, 2)) is_free = false;
        }
        if (is_free) lines.push_back({sum(from, shift), sum(to, shift)});
      }
    }
  }
  ASSERT_GT(lines.size(), 200u);
  const DistanceGrid grid(mm_, kSightSize, kSightGeometry, 1);
  const PointSpread spread = spread_of(surface_points(tree_, kSightGeometry, 3000));
  const FoundPose pose = find_pose(
      lines, {grid, grid, spread.middle, spread.axes, spread.radius_mm, 1}, false, progress_);
  EXPECT_GT(pose.overlap, 0.95);
  for (const auto& [middle, radius] : balls) {
    const Point3 place = kSightGeometry.to_world(middle);
    const Point3 laid = pose.map(sum(place, shift));
    for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(laid[a], place[a], 0.5);
  }
}

}  // namespace
}  // namespace octavo
