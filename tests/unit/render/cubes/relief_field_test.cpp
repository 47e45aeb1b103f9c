#include "octavo/render/cubes/relief_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <vector>

#include "support/built_file.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

TEST(ReliefField, RisesIntoTheRangeFromWhatIsNoNumber) {
  // Half of a volume has values in the range, the other half is no number.
  const float infinity = std::numeric_limits<float>::infinity();
  const testing::ScratchFolder folder;
  for (const float value : {std::nanf(""), infinity, -infinity}) {
    testing::Volume volume;
    volume.description.size = {16, 8, 8};
    volume.description.type = VoxelType::float32;
    testing::for_each_voxel(volume.description.size, [&](const Index3& p) {
      const float voxel = p.x < 8 ? value : static_cast<float>(-100 - p.y);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
      volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof voxel);
    });
    testing::build_volume(volume, folder.file("half.8vo"), 1);
    const auto reader = testing::open_file(folder.file("half.8vo"));
    // All finite values lie in the range, and 0 deeper in it than any.
    const auto relief = grey_relief(*reader, 0, {{-200, infinity}});
    const Box row{{6, 4, 4}, {10, 5, 5}};
    std::vector<float> field(4);
    relief->read(0, row, field.data());
    EXPECT_EQ(field[2], 96);
    EXPECT_EQ(field[3], 96);
    // NaN lies as far outside as the deepest lies inside; infinities are the ends of all values.
    const float expected = std::isnan(value) ? -100.0f : value > 0 ? 100.0f : 93.0f;
    EXPECT_EQ(field[0], expected);
    EXPECT_EQ(field[1], field[0]);
    std::filesystem::remove(folder.file("half.8vo"));
  }
}

}  // namespace
}  // namespace octavo
