#include "octavo/ops/align/pose_agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "octavo/ops/align/surface_points.h"
#include "octavo/ops/distance/distance_passes.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kBlockSize = {40, 36, 32};

/// A mask with what a posed surface needs of it.
struct MeasuredMask {
  template <class Inside>
  MeasuredMask(const Geometry& geometry, Inside inside) {
    DenseMask mask{kBlockSize, std::vector<std::uint8_t>(
                                   static_cast<std::size_t>(kBlockSize.voxel_count()))};
    for_each_voxel(kBlockSize, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
    const MaskTree tree = testing::tree_of(mask);
    NoProgress progress;
    points = surface_points(tree, geometry, 3000);
    distances.emplace(signed_distances(tree, {DistanceTo::faces, geometry.spacing_mm}, progress),
                      kBlockSize, geometry, 1);
  }

  PosedSurface surface(double voxel_mm = 1, double edge_mm = 1) const {
    return {points, *distances, voxel_mm, edge_mm};
  }

  std::vector<Point3> points;
  std::optional<DistanceGrid> distances;
};

bool is_in_block(const Index3& p) {
  return p.x >= 8 && p.x < 30 && p.y >= 9 && p.y < 27 && p.z >= 7 && p.z < 24;
}

const Geometry kUnitGeometry{{5, -3, 2}, {1, 1, 1}};

TEST(PoseAgreement, IsWholeForEqualSurfaces) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const PoseAgreement same = agreement_of(block.surface(), block.surface(), {});
  EXPECT_DOUBLE_EQ(same.forward, 1);
  EXPECT_DOUBLE_EQ(same.backward, 1);
}

TEST(PoseAgreement, FollowsSimilarities) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const Geometry large{{0, 0, 0}, {3, 3, 3}, {0, 1, 0, 0, 0, 1, 1, 0, 0}};
  const MeasuredMask other(large, is_in_block);
  const auto to_index = inverse(index_to_world(large));
  ASSERT_TRUE(to_index);
  const Affine map = chained(*to_index, index_to_world(kUnitGeometry));
  const PoseAgreement same = agreement_of(other.surface(3, 3), block.surface(), map);
  EXPECT_GT(same.forward, 0.999);
  EXPECT_GT(same.backward, 0.999);
}

TEST(PoseAgreement, AsksWhichWaySurfacesFace) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const MeasuredMask hollow(kUnitGeometry, [](const Index3& p) { return !is_in_block(p); });
  EXPECT_DOUBLE_EQ(agreement_of(block.surface(), hollow.surface(), {}).forward, 0);
}

TEST(PoseAgreement, CountsWhatIsFartherThanAVoxelAsApart) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  Affine map;
  map.offset = {3, 3, 3};
  EXPECT_LT(agreement_of(block.surface(), block.surface(), map).forward, 0.01);
}

TEST(PoseAgreement, AsksTheSecondSurfaceOnlyAroundTheFirst) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const MeasuredMask pair(kUnitGeometry, [](const Index3& p) {
    return is_in_block(p) || (p.x >= 36 && p.z > 4 && p.y > 4);
  });
  const PoseAgreement part = agreement_of(block.surface(), pair.surface(), {});
  EXPECT_GT(part.forward, 0.95);
  EXPECT_GT(part.backward, 0.8);
  // The other way round a part is missing, and what is there agrees.
  const PoseAgreement whole = agreement_of(pair.surface(), block.surface(), {});
  EXPECT_LT(whole.forward, 0.85);
  EXPECT_GT(whole.backward, 0.95);
}

/// Whether a place lies in an ellipsoid around the middle of the block's volume.
bool is_in_ellipsoid(const Index3& p, double a, double b, double c) {
  const double x = (static_cast<double>(p.x) - 19.5) / a;
  const double y = (static_cast<double>(p.y) - 17.5) / b;
  const double z = (static_cast<double>(p.z) - 15.5) / c;
  return x * x + y * y + z * z <= 1;
}

TEST(PoseAgreement, IsSharpForTheSameSurfaceAlone) {
  const auto is_round = [](const Index3& p) { return is_in_ellipsoid(p, 15, 13, 11); };
  const MeasuredMask body(kUnitGeometry, is_round);
  // Of half of it as well, by what is left.
  const MeasuredMask half(kUnitGeometry,
                          [&](const Index3& p) { return is_round(p) && p.x + p.y > 37; });
  EXPECT_GT(agreement_of(body.surface(), body.surface(), {}).sharpness, 0.99);
  EXPECT_GT(agreement_of(half.surface(), body.surface(), {}).sharpness, 0.9);
  // Most of another surface agrees within a voxel, and little within half of one.
  const MeasuredMask other(kUnitGeometry,
                           [](const Index3& p) { return is_in_ellipsoid(p, 14, 12.3, 12.3); });
  const PoseAgreement apart = agreement_of(body.surface(), other.surface(), {});
  EXPECT_GT(apart.forward, 0.6);
  EXPECT_GT(apart.backward, 0.6);
  EXPECT_LT(apart.sharpness, 0.7);
}

TEST(PoseAgreement, CountsWhereVoxelsAreLongInTheirMeanEdge) {
  // A slope that voxels of 1 x 1 x 4 show in steps, and such of 1 x 1 x 1 finely.
  Geometry flat = kUnitGeometry;
  flat.spacing_mm = {1, 1, 4};
  const MeasuredMask coarse(flat, [](const Index3& p) { return p.x + 4 * p.z < 50; });
  const MeasuredMask fine(kUnitGeometry, [](const Index3& p) { return p.x + p.z < 50; });
  const PoseAgreement one =
      agreement_of(coarse.surface(std::cbrt(4.0), 2), fine.surface(), {});
  EXPECT_GT(one.sharpness, 0.75);
}

TEST(PoseAgreement, APlanePartsWhatCutsTookAway) {
  const auto part = [](std::int64_t from, std::int64_t to) {
    return MeasuredMask(kUnitGeometry, [=](const Index3& p) {
      return is_in_block(p) && p.x >= from && p.x < to;
    });
  };
  const MeasuredMask low = part(0, 24);
  const MeasuredMask high = part(14, 40);
  const PoseAgreement cut = agreement_of(low.surface(), high.surface(), {});
  EXPECT_GT(cut.parting, 0.98);
  EXPECT_GT(cut.sharpness, 0.9);
  // What lies all around is no cut.
  const MeasuredMask along_x(kUnitGeometry, [](const Index3& p) {
    return is_in_block(p) || (p.x >= 2 && p.x < 36 && p.y >= 12 && p.y < 24 && p.z >= 10 &&
                              p.z < 21);
  });
  const MeasuredMask along_y(kUnitGeometry, [](const Index3& p) {
    return is_in_block(p) || (p.y >= 2 && p.y < 34 && p.x >= 13 && p.x < 25 && p.z >= 10 &&
                              p.z < 21);
  });
  const PoseAgreement crossed = agreement_of(along_x.surface(), along_y.surface(), {});
  EXPECT_GT(crossed.forward, 0.5);
  EXPECT_LT(crossed.parting, 0.8);
}

TEST(PoseAgreement, PointsOfACutFaceNothing) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const MeasuredMask half(kUnitGeometry,
                          [](const Index3& p) { return is_in_block(p) && p.x < 20; });
  const std::vector<Point3> facing = facing_points(half.surface(), block.surface(), {});
  EXPECT_GT(facing.size(), half.points.size() / 2);
  EXPECT_LT(facing.size(), half.points.size());
  const double cut = kUnitGeometry.to_world({19.5, 0, 0})[0];
  std::size_t on_cut = 0;
  for (const Point3& p : facing) {
    if (p[0] == cut) ++on_cut;
  }
  EXPECT_LT(on_cut, facing.size() / 50);
}

TEST(PoseAgreement, SharpnessOfDistancesIsTheShareOfNearOnes) {
  const std::vector<double> mm = {0.1, -0.9, 1.1, 7.9, 8.1, -50};
  EXPECT_DOUBLE_EQ(sharpness_of(mm, 2), 0.5);
  EXPECT_DOUBLE_EQ(sharpness_of({}, 2), 0);
}

TEST(PoseAgreement, IsSmallBackwardInACrowd) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const MeasuredMask crowd(kUnitGeometry, [](const Index3& p) {
    return is_in_block(p) != (p.x % 6 < 3 && p.y % 6 < 3);
  });
  EXPECT_LT(agreement_of(block.surface(), crowd.surface(), {}).backward, 0.4);
}

}  // namespace
}  // namespace octavo
