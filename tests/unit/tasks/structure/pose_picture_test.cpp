#include "octavo/tasks/structure/pose_picture.h"

#include <gtest/gtest.h>

#include <array>

#include "support/dense_mask.h"

namespace octavo {
namespace {

TEST(PosePicture, PlacesHaveTheColorOfTheirDistance) {
  const Size3 size = {20, 10, 10};
  testing::DenseMask mask{size, std::vector<std::uint8_t>(2000)};
  testing::for_each_voxel(size, [&](const Index3& p) { mask.at(p) = p.x < 10 ? 1 : 0; });
  const Geometry geometry{{0, 0, 0}, {1, 1, 1}};
  const std::vector<PosedPlace> places = {
      {{2, 4, 4}, 0.5}, {{12, 4, 4}, -1.5}, {{18, 4, 4}, 9}, {{300, 0, 0}, 0}};
  const Picture picture = pose_picture(testing::tree_of(mask), geometry, places, 1);
  ASSERT_EQ(picture.channels, 3);
  std::array<int, 3> seen{};  // greenish, yellowish, reddish
  for (std::size_t i = 0; i < picture.pixels.size(); i += 3) {
    const int r = picture.pixels[i];
    const int g = picture.pixels[i + 1];
    const int b = picture.pixels[i + 2];
    if (r == g && g == b) continue;
    ++seen[g > r ? 0 : g > 100 ? 1 : 2];
  }
  // Each place of four pixels in three views, as far as one does not hide another.
  EXPECT_GE(seen[0], 8);
  EXPECT_GE(seen[1], 8);
  EXPECT_GE(seen[2], 8);
  EXPECT_LE(seen[0] + seen[1] + seen[2], 36);
}

}  // namespace
}  // namespace octavo
