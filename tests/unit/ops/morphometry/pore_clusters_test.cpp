#include "octavo/ops/morphometry/pore_clusters.h"

#include <gtest/gtest.h>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::for_each_voxel;

template <class Pore>
std::vector<std::uint8_t> pores_of(const Size3& size, Pore pore) {
  std::vector<std::uint8_t> pores;
  for_each_voxel(size, [&](const Index3& p) { pores.push_back(pore(p) ? 1 : 0); });
  return pores;
}

/// Of each cluster, all its conductances together.
std::vector<double> sums_of(const PoreClusters& clusters) {
  std::vector<double> sums;
  for (std::size_t i = 0; i < clusters.count(); ++i) {
    double sum = static_cast<double>(clusters.ends[i]);
    for (auto k = clusters.link_starts[i]; k < clusters.link_starts[i + 1]; ++k) {
      sum += static_cast<double>(clusters.conductances[static_cast<std::size_t>(k)]);
    }
    sums.push_back(sum);
  }
  return sums;
}

TEST(PoreClusters, OfACubeAreAGridOfTwiceTheSpacing) {
  const NoProgress progress;
  const Size3 size = {6, 4, 8};
  const PoreNetwork network(pores_of(size, [](const Index3&) { return true; }), size, {1, 1, 1}, 2,
                            progress);
  MergedPores found = merged(network);
  EXPECT_EQ(found.clusters.size, (Size3{3, 2, 4}));
  ASSERT_EQ(found.clusters.count(), 24U);
  // Faces of 4 over a distance of 2; ends as far away as before, seen from a center twice as far.
  const double face = 2;
  PoreClusters& clusters = found.clusters;
  for (std::int64_t z = 0; z < 4; ++z) {
    for (std::int64_t y = 0; y < 2; ++y) {
      const PoreRow row = clusters.row(y, z);
      ASSERT_EQ(row.end - row.begin, 3);
      for (std::int32_t one = row.begin; one < row.end; ++one) {
        const std::int64_t x = clusters.x_of(one);
        EXPECT_EQ(x, one - row.begin);
        EXPECT_EQ(clusters.colors[static_cast<std::size_t>(one)], (x + y + z) % 2);
        EXPECT_EQ(clusters.to_ends(one), z == 0 || z == 3 ? 2 * face : 0);
        clusters.visit_links(one, row, [&](int side, std::int32_t other, double conductance) {
          const std::int32_t steps[] = {-1, 1, -3, 3, -6, 6};
          EXPECT_EQ(other - one, steps[side]);
          EXPECT_EQ(conductance, face);
        });
      }
    }
  }
  // A relaxation lets the places go, and shares rows out by how many clusters there are.
  clusters.along_x = {};
  EXPECT_EQ(clusters.count(), 24U);
}

TEST(PoreClusters, KeepApartWhatAWallParts) {
  // Two channels along z in the same blocks, joined in the last plane alone.
  const NoProgress progress;
  const Size3 size = {3, 1, 9};
  const PoreNetwork network(
      pores_of(size, [](const Index3& p) { return p.x != 1 || p.z == 8; }), size, {1, 1, 1}, 2,
      progress);
  ASSERT_EQ(network.count(), 19U);
  MergedPores found = merged(network);
  // Five blocks high; the joint belongs to the left channel's.
  EXPECT_EQ(found.clusters.size, (Size3{2, 1, 5}));
  EXPECT_EQ(found.clusters.count(), 10U);
  EXPECT_EQ(found.cluster_of[0], 0);
  found = merged(found.clusters, network);
  EXPECT_EQ(found.clusters.size, (Size3{1, 1, 3}));
  // The upper blocks have both channels apart, the last one joined.
  EXPECT_EQ(found.clusters.count(), 5U);
  found = merged(found.clusters, network);
  EXPECT_EQ(found.clusters.count(), 3U);
  found = merged(found.clusters, network);
  ASSERT_EQ(found.clusters.count(), 1U);
  EXPECT_FALSE(found.clusters.has_links());
  // Two pores before the one end, three behind the other: a conductance of 2 each, halved by each
  // of the four merges along z.
  EXPECT_FLOAT_EQ(found.clusters.ends[0], (2 + 3) * 2.0F / 16);
}

TEST(PoreClusters, OfLongVoxelsAreMergedAcrossThemFirst) {
  const NoProgress progress;
  const Size3 size = {8, 8, 4};
  const PoreNetwork network(pores_of(size, [](const Index3&) { return true; }), size, {1, 1, 5}, 0,
                            progress);
  MergedPores found = merged(network);
  EXPECT_EQ(found.widths, (BlockWidths{2, 2, 1}));
  // Faces of 2 by 5 over a distance of 2; along z the centers stay: faces of 4 over 5.
  EXPECT_FLOAT_EQ(static_cast<float>(sums_of(found.clusters)[5]), 4 * 5 + 4 * 1.0F / 5);
  found = merged(found.clusters, network);
  EXPECT_EQ(found.widths, (BlockWidths{2, 2, 1}));
  found = merged(found.clusters, network);
  EXPECT_EQ(found.widths, (BlockWidths{2, 2, 2}));
  EXPECT_EQ(found.clusters.size, (Size3{1, 1, 2}));
}

}  // namespace
}  // namespace octavo
