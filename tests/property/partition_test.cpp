// Whatever a volume is and however its groups are parted, its parts join into the bytes of a build.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "octavo/builder/group_reader.h"
#include "support/goal_cases.h"
#include "support/part_volumes.h"
#include "support/parted_volume.h"

namespace octavo::testing {
namespace {

/// More than one page of bricks a layer, and three tiers: too large to be built often.
std::vector<SmallVolume> large_volumes() {
  // Of thick slices, so that a layer has few planes
  SmallVolume wide = small_volume("1056 bricks a layer", VoxelType::uint8, {2112, 2048, 12});
  wide.description.geometry.spacing_mm = {1, 1, 16};
  return {wide, small_volume("three tiers", VoxelType::uint8, {4, 4, 4300})};
}

Places random_runs(const BuildPlan& plan, std::mt19937& random) {
  Places runs;
  const auto most = std::uniform_int_distribution<std::int64_t>(1, plan.group_count)(random);
  for (std::int64_t at = 0; at < plan.group_count;) {
    const auto count = std::uniform_int_distribution<std::int64_t>(1, most)(random);
    const std::int64_t end = std::min(at + count, plan.group_count);
    runs.push_back({plan.id, at, end});
    at = end;
  }
  std::ranges::shuffle(runs, random);
  return runs;
}

constexpr std::uint64_t kMostBandBytes = std::uint64_t{1} << 17;

TEST(Partition, AnyPartsInAnyOrderMakeTheFileOfABuild) {
  const SmallGroups groups(kPartGroupBytes);
  std::vector<PartedVolume> volumes;
  for (SmallVolume& volume : part_volumes()) {
    const std::string name = volume.name;
    volumes.emplace_back(std::move(volume), kMostBandBytes);
    EXPECT_GE(volumes.back().plan().group_count, 3) << name;
  }
  const std::uint64_t count = case_count(300, 10'000);
  GoalCases cases("E4", "random partitions", count);
  for (std::uint64_t i = 0; cases.next(); ++i) {
    std::mt19937 random(static_cast<std::uint32_t>(i));
    PartedVolume& volume = volumes[i % volumes.size()];
    volume.expect_same(random_runs(volume.plan(), random), random);
    if (HasFatalFailure()) FAIL() << "partition " << i;
  }
  cases.tell("all of them the bytes of a build");
}

TEST(Partition, SeveralPagesALayerAndThreeTiersMakeTheFileOfABuild) {
  for (SmallVolume& volume : large_volumes()) {
    const SmallGroups groups(1 << 10);
    PartedVolume large(std::move(volume), kMostBandBytes);
    std::mt19937 random(7);
    ASSERT_GE(large.plan().group_count, 3);
    large.expect_same(random_runs(large.plan(), random), random);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace octavo::testing
