#include "octavo/ops/distance/site_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "octavo/core/error.h"
#include "support/dense_mask.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

DenseMask noise(const Size3& size, int one_in) {
  std::mt19937 random(static_cast<unsigned>(one_in));
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  for (std::uint8_t& voxel : mask.voxels) {
    voxel = random() % static_cast<unsigned>(one_in) == 0 ? 1 : 0;
  }
  return mask;
}

double squared_mm(const Index3& steps, const Point3& spacing) {
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double mm = static_cast<double>(steps[axis]) * spacing[static_cast<std::size_t>(axis)];
    squared += mm * mm;
  }
  return squared;
}

std::vector<NearestSite> sites_of(const DenseMask& mask, const Point3& spacing,
                                  std::uint64_t max_bytes) {
  const MaskTree tree = testing::tree_of(mask);
  testing::MemoryStorage storage;
  NoProgress progress;
  const auto field = make_site_field(inside_of(tree), spacing, max_bytes, storage, ".", progress);
  std::vector<NearestSite> sites(mask.voxels.size());
  field->read(0, mask.size.z, sites.data());
  return sites;
}

TEST(SiteField, SitesAreNearestVoxelsOfTheOtherClass) {
  for (const Point3& spacing : {Point3{1, 1, 1}, Point3{0.7, 1.1, 2.3}}) {
    for (const int one_in : {2, 9, 200}) {
      const DenseMask mask = noise({13, 11, 19}, one_in);
      const std::vector<NearestSite> sites = sites_of(mask, spacing, 1 << 20);
      std::size_t i = 0;
      for_each_voxel(mask.size, [&](const Index3& p) {
        const NearestSite& site = sites[i++];
        EXPECT_EQ(site.is_inside(), mask.at(p) != 0);
        double nearest = HUGE_VAL;
        for_each_voxel(mask.size, [&](const Index3& q) {
          if (mask.at(q) == mask.at(p)) return;
          nearest = std::min(nearest, squared_mm({q.x - p.x, q.y - p.y, q.z - p.z}, spacing));
        });
        const Index3 steps = {site.steps[0], site.steps[1], site.steps[2]};
        const Index3 at = {p.x + steps.x, p.y + steps.y, p.z + steps.z};
        ASSERT_TRUE(box_of(mask.size).contains(at));
        EXPECT_NE(mask.at(at), mask.at(p));
        EXPECT_NEAR(squared_mm(steps, spacing), nearest, 1e-9);
        const auto j = static_cast<std::size_t>((at.z * mask.size.y + at.y) * mask.size.x + at.x);
        EXPECT_EQ(site.site_share, sites[j].own_share());
      });
    }
  }
}

TEST(SiteField, OnDiskIsThatInMemory) {
  const DenseMask mask = noise({13, 11, 37}, 40);
  const auto held = sites_of(mask, {1, 2, 1}, 1 << 20);
  const auto written = sites_of(mask, {1, 2, 1}, 1);
  for (std::size_t i = 0; i < held.size(); ++i) {
    EXPECT_EQ(held[i].steps, written[i].steps);
    EXPECT_EQ(held[i].own, written[i].own);
    EXPECT_EQ(held[i].site_share, written[i].site_share);
  }
}

TEST(SiteField, KnowsNoSiteWhereThereIsOneClass) {
  for (const NearestSite& site : sites_of(noise({5, 4, 3}, 1), {1, 1, 1}, 1 << 20)) {
    EXPECT_FALSE(site.is_known());
  }
}

TEST(SiteField, LongerAxesThanStepsAreRejected) {
  const InsideVoxels voxels{{1, 1, 32768}, [](const Box&, std::uint8_t*) {}};
  testing::MemoryStorage storage;
  NoProgress progress;
  try {
    make_site_field(voxels, {1, 1, 1}, 1 << 20, storage, ".", progress);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

}  // namespace
}  // namespace octavo
