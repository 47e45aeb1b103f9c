// However many ranks condense a volume, and by whatever plan, its octree is that of one.
#include "octavo/dist/rank_codes.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "octavo/dist/thread_ranks.h"

namespace octavo {
namespace {

constexpr GatherPlan kGatherPlans[] = {GatherPlan::tree, GatherPlan::mesh};

/// Labels in boxes, so that some octants are homogeneous, and some noise.
std::vector<std::uint8_t> boxed_labels(const Size3& size) {
  std::vector<std::uint8_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  const std::int64_t side = *rc::gen::inRange<std::int64_t>(1, 9);
  const int labels = *rc::gen::inRange(1, 4);
  const int noise = *rc::gen::inRange(0, 4);
  const auto seed = *rc::gen::arbitrary<std::uint32_t>();
  std::size_t at = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const auto box = static_cast<std::uint32_t>(x / side + 3 * (y / side) + 7 * (z / side));
        const std::uint32_t random = (static_cast<std::uint32_t>(at) + seed) * 2654435761u;
        const bool is_noise = noise > 0 && random >> 24 < static_cast<std::uint32_t>(noise);
        const std::uint32_t label =
            (is_noise ? random >> 8 : box) % (static_cast<std::uint32_t>(labels) + 1);
        voxels[at++] = static_cast<std::uint8_t>(label);
      }
    }
  }
  return voxels;
}

LinearOctree by_ranks(const std::vector<std::uint8_t>& voxels, const Size3& size,
                      std::optional<std::int64_t> background, int count, GatherPlan plan,
                      RankReport& report) {
  LinearOctree octree;
  const auto plane_voxels = static_cast<std::size_t>(size.x * size.y);
  run_thread_ranks(count, [&](Communicator& ranks) {
    std::int64_t next = 0;
    const CondensedPlanes planes = {
        size, [&](std::int64_t first, std::int64_t) { next = first; },
        [&](PlaneCondenser& condenser) {
          const auto at = static_cast<std::size_t>(next++) * plane_voxels;
          condenser.add_plane(VoxelType::uint8,
                              std::as_bytes(std::span(voxels).subspan(at, plane_voxels)));
        }};
    NoProgress progress;
    RankReport own;
    LinearOctree leaves =
        condense_by_ranks(planes, background, ranks, plan, progress, &own);
    if (!ranks.is_first()) {
      EXPECT_EQ(leaf_count(leaves), 0);
      return;
    }
    octree = std::move(leaves);
    report = own;
  });
  return octree;
}

TEST(RankCodes, OctreesAreThoseOfOneCondenser) {
  const auto property = [] {
    const Size3 size{*rc::gen::inRange<std::int64_t>(1, 20), *rc::gen::inRange<std::int64_t>(1, 20),
                     *rc::gen::inRange<std::int64_t>(1, 40)};
    const std::vector<std::uint8_t> voxels = boxed_labels(size);
    std::optional<std::int64_t> background;
    if (*rc::gen::arbitrary<bool>()) background = 0;
    const LinearOctree expected =
        condense<std::uint8_t>(voxels, size, CondenseOptions{background, 0});
    const int count = *rc::gen::inRange(1, 9);
    for (const GatherPlan plan : kGatherPlans) {
      RankReport report;
      RC_ASSERT(by_ranks(voxels, size, background, count, plan, report) == expected);
      RC_ASSERT(report.codes() == static_cast<std::uint64_t>(leaf_count(expected)));
      RC_ASSERT(report.ranks.size() == static_cast<std::size_t>(count));
      std::uint64_t planes = 0;
      for (const RankShare& rank : report.ranks) planes += rank.units;
      RC_ASSERT(planes == static_cast<std::uint64_t>(size.z));
    }
  };
  EXPECT_TRUE(rc::check(property));
}

TEST(RankCodes, OneRankSendsNothing) {
  const Size3 size{8, 8, 8};
  const std::vector<std::uint8_t> voxels(512, 3);
  RankReport report;
  const LinearOctree octree = by_ranks(voxels, size, 0, 1, GatherPlan::tree, report);
  EXPECT_EQ(leaf_count(octree, 3), 1);
  EXPECT_EQ(report.codes_sent(), 0u);
  EXPECT_EQ(report.bytes_sent(), 0u);
}

// Four workers with eight planes each, as in the thesis: level 3 goes up.
TEST(RankCodes, CodesOfTheLevelOfRunsGoUp) {
  EXPECT_EQ(run_level(32, 4), 3);
  EXPECT_EQ(run_level(32, 1), 5);
  EXPECT_EQ(run_level(3, 8), 0);
  EXPECT_EQ(run_level(33, 4), 3);
  const Size3 size{32, 32, 32};
  const std::vector<std::uint8_t> voxels(32768, 1);
  for (const GatherPlan plan : kGatherPlans) {
    RankReport report;
    const LinearOctree octree = by_ranks(voxels, size, 0, 4, plan, report);
    EXPECT_EQ(leaf_count(octree, 5), 1);
    EXPECT_EQ(report.levels[2].sent, 0u);
    EXPECT_GE(report.levels[3].sent, 16u);
  }
}

// II tells I and IV tells III sixteen codes of level 3; III then has four of level 4, and tells I.
TEST(RankCodes, TheMeshCondensesOnTheWay) {
  const Size3 size{32, 32, 32};
  const std::vector<std::uint8_t> voxels(32768, 1);
  RankReport report;
  by_ranks(voxels, size, 0, 4, GatherPlan::mesh, report);
  EXPECT_EQ(report.levels[3].sent, 32u);
  EXPECT_EQ(report.levels[4].sent, 4u);
}

}  // namespace
}  // namespace octavo
