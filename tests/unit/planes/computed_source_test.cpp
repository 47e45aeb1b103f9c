#include "octavo/planes/computed_source.h"

#include <gtest/gtest.h>

#include "support/sought_planes.h"

namespace octavo {
namespace {

TEST(ComputedSource, PlanesAreTheSameFromAnywhereAndNoneBehindThemIsMade) {
  VolumeDescription description;
  description.type = VoxelType::uint8;
  description.size = {3, 2, 11};
  std::int64_t last = 0;
  const auto fill = [&](const Box& box, std::byte* voxels) {
    last = std::max(last, box.hi.z);
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (int i = 0; i < 6; ++i) *voxels++ = static_cast<std::byte>(z * 6 + i);
    }
  };
  const auto source = make_computed_source(description, fill, 4);
  testing::planes_between(*source, 1, 3);
  EXPECT_EQ(last, 3);
  testing::expect_same_from_anywhere(*source);
}

}  // namespace
}  // namespace octavo
