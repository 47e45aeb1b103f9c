#include "octavo/ops/distance/site_shares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "octavo/core/vectors.h"
#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

std::vector<NearestSite> shares_of(const DenseMask& mask) {
  const MaskTree tree = testing::tree_of(mask);
  std::vector<NearestSite> sites(mask.voxels.size());
  fill_shares(inside_of(tree), 0, mask.size.z, sites.data());
  return sites;
}

/// The share of one voxel of a mask.
template <class Inside>
std::uint8_t share_at(const Index3& place, Inside inside) {
  DenseMask mask{{13, 13, 13}, std::vector<std::uint8_t>(13 * 13 * 13)};
  for_each_voxel(mask.size, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
  return shares_of(mask)[static_cast<std::size_t>((place.z * 13 + place.y) * 13 + place.x)]
      .own_share();
}

TEST(SiteShares, SurfacesAreFlatUpToCliffsButNotOverSteps) {
  for (const std::int64_t wide : {1, 2, 3}) {
    const auto is_in_rod = [&](const Index3& p) {
      return p.x >= 5 && p.x < 5 + wide && p.z >= 5 && p.z < 5 + wide;
    };
    EXPECT_EQ(share_at({5, 6, 4}, is_in_rod), kFlatShare) << wide;
    EXPECT_EQ(share_at({5, 6, 4}, [&](const Index3& p) { return !is_in_rod(p); }),
              share_at({5, 6, 4}, is_in_rod)) << wide;
    EXPECT_EQ(share_at({5, 6, 5}, [&](const Index3& p) { return !is_in_rod(p); }), kFlatShare);
  }
  for (const std::int64_t slope : {1, 2, 3}) {
    const auto is_below = [&](const Index3& p) { return p.z <= 6 + slope * (p.x - 6); };
    EXPECT_NE(share_at({6, 6, 7}, is_below), kFlatShare) << slope;
    EXPECT_NE(share_at({6, 6, 6}, is_below), kFlatShare) << slope;
  }
}

TEST(SiteShares, FlatSurfacesPassHalfWay) {
  for (const std::int64_t thick : {1, 2, 5}) {
    DenseMask mask{{9, 9, 16}, std::vector<std::uint8_t>(9 * 9 * 16)};
    for_each_voxel(mask.size, [&](const Index3& p) {
      mask.at(p) = p.z >= 6 && p.z < 6 + thick ? 1 : 0;
    });
    const auto sites = shares_of(mask);
    for (const std::int64_t z : {std::int64_t{5}, 6 + thick}) {
      const NearestSite& site = sites[static_cast<std::size_t>((z * 9 + 4) * 9 + 4)];
      EXPECT_FALSE(site.is_inside());
      EXPECT_EQ(site.own_share(), kFlatShare) << thick;
      EXPECT_EQ(surface_gap(site.own_share()), 0.5);
    }
    EXPECT_EQ(sites[4 * 9 + 4].own_share(), 0);
  }
}

TEST(SiteShares, SayWhereRandomPlanesPass) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  double off = 0;
  double squares = 0;
  int count = 0;
  for (int i = 0; i < 2000; ++i) {
    const Point3 normal = unit({anywhere(random), anywhere(random), anywhere(random)});
    const double gap = 0.3 + 0.3 * anywhere(random);
    DenseMask mask{{5, 5, 5}, std::vector<std::uint8_t>(125)};
    for_each_voxel(mask.size, [&](const Index3& p) {
      const Point3 at = {static_cast<double>(p.x - 2), static_cast<double>(p.y - 2),
                         static_cast<double>(p.z - 2)};
      mask.at(p) = dot(at, normal) > gap ? 1 : 0;
    });
    const NearestSite site = shares_of(mask)[62];
    ASSERT_FALSE(site.is_inside());
    const double more = surface_gap(site.own_share()) - gap;
    off += more;
    squares += more * more;
    ++count;
  }
  EXPECT_NEAR(off / count, 0, 0.02);
  EXPECT_LT(std::sqrt(squares / count), 0.13);
}

TEST(SiteShares, OfBlocksOfPlanesAreThoseOfAll) {
  std::mt19937 random(1);
  DenseMask mask{{11, 7, 20}, std::vector<std::uint8_t>(11 * 7 * 20)};
  for (std::uint8_t& voxel : mask.voxels) voxel = random() % 3 == 0 ? 1 : 0;
  const auto all = shares_of(mask);
  const MaskTree tree = testing::tree_of(mask);
  std::vector<NearestSite> some(5 * 77);
  fill_shares(inside_of(tree), 8, 13, some.data());
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i].own, all[8 * 77 + i].own);
}

}  // namespace
}  // namespace octavo
