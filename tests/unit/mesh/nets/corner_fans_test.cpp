#include "octavo/mesh/nets/corner_fans.h"

#include <gtest/gtest.h>

#include <bit>
#include <set>

namespace octavo {
namespace {

/// Numbers of the fans of the faces of a mask.
std::set<unsigned> fans_of(CornerMask mask) {
  std::set<unsigned> fans;
  for (std::size_t face = 0; face < CornerFans::kFaces; ++face) {
    const std::size_t below = CornerEdge{face / 4, false}.voxel(face % 4);
    const std::size_t above = CornerEdge{face / 4, true}.voxel(face % 4);
    if ((mask >> below & 1) != (mask >> above & 1)) {
      fans.insert(CornerFans::shared().fan(mask, face));
    }
  }
  return fans;
}

TEST(CornerFans, AreOneForEachSurface) {
  EXPECT_TRUE(fans_of(0).empty());
  EXPECT_TRUE(fans_of(0xff).empty());
  EXPECT_EQ(fans_of(0b0000'0001).size(), 1u);
  EXPECT_EQ(fans_of(0b0000'1111).size(), 1u);
  EXPECT_EQ(fans_of(0b0000'1001).size(), 2u);  // at an edge
  EXPECT_EQ(fans_of(0b1000'0001).size(), 2u);  // at the corner alone
  EXPECT_EQ(fans_of(0b0110'1001).size(), 4u);  // no two share a face
  EXPECT_EQ(fans_of(0b0110'1011).size(), 2u);
  // Around the edge and hanging together behind it.
  EXPECT_EQ(fans_of(0b1111'1001).size(), 1u);
}

TEST(CornerFans, AreNumberedFromZero) {
  for (unsigned mask = 1; mask < 255; ++mask) {
    const std::set<unsigned> fans = fans_of(static_cast<CornerMask>(mask));
    EXPECT_EQ(*fans.rbegin() + 1, fans.size());
    EXPECT_LE(fans.size(), 4u);
    if (fans.size() > 1) {
      EXPECT_TRUE(CornerFans::shared().is_touching(static_cast<CornerMask>(mask)));
    }
  }
  EXPECT_FALSE(CornerFans::shared().is_touching(0b0000'1111));
  EXPECT_TRUE(CornerFans::shared().is_touching(0b1111'1001));
}

TEST(CornerFans, OfAnEdgeAreThoseOfItsVoxels) {
  // Along the upper z edge voxels 4 and 7 have one label, 5 and 6 others or one as well.
  const CornerEdge up{2, true};
  const CornerEdge down{2, false};
  const auto classes = [](std::array<unsigned, 4> above) {
    CornerClasses all = 0;
    for (std::size_t k = 0; k < 4; ++k) all |= above[k] << 3 * (4 + k);
    return all;
  };
  for (const CornerClasses crossed : {classes({1, 2, 2, 1}), classes({1, 2, 3, 1})}) {
    EXPECT_TRUE(is_crossed(crossed, up));
    EXPECT_FALSE(is_crossed(crossed, down));
    EXPECT_EQ(edge_fan(crossed, up, 4), 0u);
    EXPECT_EQ(edge_fan(crossed, up, 7), 1u);
  }
  EXPECT_EQ(edge_fan(classes({1, 2, 2, 1}), up, 6), 1u);
  EXPECT_EQ(edge_fan(classes({1, 2, 3, 1}), up, 6), 0u);
  EXPECT_FALSE(is_crossed(classes({1, 2, 3, 4}), up));
  EXPECT_FALSE(is_crossed(classes({1, 1, 2, 1}), up));
}

}  // namespace
}  // namespace octavo
