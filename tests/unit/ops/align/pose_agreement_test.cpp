#include "octavo/ops/align/pose_agreement.h"

#include <gtest/gtest.h>

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

  PosedSurface surface(double voxel_mm = 1) const { return {points, *distances, voxel_mm}; }

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
  const PoseAgreement same = agreement_of(other.surface(3), block.surface(), map);
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

TEST(PoseAgreement, IsSmallBackwardInACrowd) {
  const MeasuredMask block(kUnitGeometry, is_in_block);
  const MeasuredMask crowd(kUnitGeometry, [](const Index3& p) {
    return is_in_block(p) != (p.x % 6 < 3 && p.y % 6 < 3);
  });
  EXPECT_LT(agreement_of(block.surface(), crowd.surface(), {}).backward, 0.4);
}

}  // namespace
}  // namespace octavo
