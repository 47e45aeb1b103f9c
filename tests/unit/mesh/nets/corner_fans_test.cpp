#include "octavo/mesh/nets/corner_fans.h"

#include <gtest/gtest.h>

#include <array>
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

CornerSurfaces surfaces_of(const std::array<CornerMask, 4>& masks) {
  CornerSurfaces all;
  for (const CornerMask mask : masks) all.join(CornerFans::shared().surfaces(mask));
  return all;
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
  const auto classes = [](std::array<std::size_t, 4> above) {
    std::array<CornerMask, 4> masks = {0b1111};
    for (std::size_t k = 0; k < 4; ++k) {
      masks[above[k]] = static_cast<CornerMask>(masks[above[k]] | 1u << (4 + k));
    }
    return surfaces_of(masks);
  };
  for (const CornerSurfaces& crossed : {classes({1, 2, 2, 1}), classes({1, 2, 3, 1})}) {
    EXPECT_TRUE(crossed.is_crossed(up));
    EXPECT_FALSE(crossed.is_crossed(down));
    EXPECT_EQ(crossed.edge_fan(up, 4), 0u);
    EXPECT_EQ(crossed.edge_fan(up, 7), 1u);
  }
  EXPECT_EQ(classes({1, 2, 2, 1}).edge_fan(up, 6), 1u);
  EXPECT_EQ(classes({1, 2, 3, 1}).edge_fan(up, 6), 0u);
  EXPECT_FALSE(classes({0, 1, 2, 3}).is_crossed(up));
  EXPECT_FALSE(classes({1, 1, 2, 1}).is_crossed(up));
}

TEST(CornerFans, OfSurfacesAreThoseOfEachMask) {
  for (unsigned number = 0; number < 256; ++number) {
    const auto mask = static_cast<CornerMask>(number);
    const auto rest = static_cast<CornerMask>(~number);
    const CornerSurfaces surfaces = surfaces_of({mask, rest});
    for (std::size_t face = 0; face < CornerFans::kFaces; ++face) {
      const std::size_t below = CornerEdge{face / 4, false}.voxel(face % 4);
      const std::size_t above = CornerEdge{face / 4, true}.voxel(face % 4);
      if ((mask >> below & 1) == (mask >> above & 1)) continue;
      const bool is_below = (mask >> below & 1) != 0;
      const unsigned first = CornerFans::shared().fan(is_below ? mask : rest, face);
      const unsigned second = CornerFans::shared().fan(is_below ? rest : mask, face);
      EXPECT_EQ(surfaces.fans(face), first | second << 2) << number << " " << face;
    }
  }
}

}  // namespace
}  // namespace octavo
