#include "octavo/core/nearest_voxel.h"

#include <gtest/gtest.h>

namespace octavo {
namespace {

TEST(NearestVoxel, HalfwayIsTheHigherAlsoWhereRoundingFellShort) {
  for (const std::int64_t voxel : {-3, -1, 0, 4, 1000}) {
    const auto at = static_cast<double>(voxel);
    EXPECT_EQ(nearest_voxel(at), voxel);
    EXPECT_EQ(nearest_voxel(at - 0.5), voxel);
    EXPECT_EQ(nearest_voxel(at - 0.5 - 1e-9), voxel);
    EXPECT_EQ(nearest_voxel(at + 0.5 - 1e-5), voxel);
    EXPECT_EQ(nearest_voxel(at + 0.5), voxel + 1);
  }
}

TEST(NearestVoxel, VoxelsEndHalfAVoxelBeyondTheOutermostCenters) {
  EXPECT_TRUE(is_in_voxels(-0.5, 7));
  EXPECT_TRUE(is_in_voxels(-0.5 - 1e-9, 7));
  EXPECT_TRUE(is_in_voxels(6.5, 7));
  EXPECT_FALSE(is_in_voxels(-0.50001, 7));
  EXPECT_FALSE(is_in_voxels(6.50001, 7));
}

}  // namespace
}  // namespace octavo
