#include "octavo/octree/mask_accessor.h"

#include <gtest/gtest.h>

#include "support/dense_mask.h"

namespace octavo {
namespace {

TEST(MaskAccessor, GivesEveryVoxelOfTheMask) {
  std::mt19937 random(1);
  for (const Size3& size : testing::odd_sizes()) {
    for (int turn = 0; turn < 3; ++turn) {
      const testing::DenseMask mask = testing::random_mask(size, random);
      const MaskTree tree = testing::tree_of(mask);
      const MaskAccessor accessor(tree);
      bool is_same = true;
      testing::for_each_voxel(size, [&](const Index3& p) {
        is_same = is_same && accessor.contains(p) == (mask.at(p) != 0);
      });
      EXPECT_TRUE(is_same) << size.x << ' ' << size.y << ' ' << size.z;
    }
  }
}

TEST(MaskAccessor, HasNothingOutsideTheVolume) {
  const MaskTree mask = box_mask({20, 30, 40}, {{0, 0, 0}, {20, 30, 40}});
  const MaskAccessor accessor(mask);
  EXPECT_TRUE(accessor.contains({19, 29, 39}));
  for (const Index3& p : {Index3{-1, 0, 0}, Index3{20, 0, 0}, Index3{0, -1, 0}, Index3{0, 30, 0},
                          Index3{0, 0, -1}, Index3{0, 0, 40},
                          Index3{std::int64_t{1} << 40, 0, 0}}) {
    EXPECT_FALSE(accessor.contains(p));
  }
}

TEST(MaskAccessor, StaysSmallInAVolumeThatIsHuge) {
  // Entries of 16^3 would be 2^45 of them.
  const std::int64_t side = std::int64_t{1} << 19;
  const Box box{{70000, 123, side - 300}, {70100, 300, side - 100}};
  const MaskTree mask = box_mask({side, side, side}, box);
  const MaskAccessor accessor(mask);
  EXPECT_LE(accessor.memory_bytes(), std::uint64_t{1} << 20);
  std::mt19937 random(2);
  for (int i = 0; i < 20000; ++i) {
    const auto near = [&](int axis) {
      return box.lo[axis] - 20 +
             static_cast<std::int64_t>(random() %
                                       static_cast<std::uint64_t>(box.size()[axis] + 40));
    };
    const Index3 p{near(0), near(1), near(2)};
    ASSERT_EQ(accessor.contains(p), box.contains(p));
  }
}

}  // namespace
}  // namespace octavo
