// Whatever a volume is and however its groups are parted, its parts join into the bytes of a build.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "octavo/builder/group_reader.h"
#include "octavo/dist/plan_text.h"
#include "support/goal_cases.h"
#include "support/part_volumes.h"

namespace octavo::testing {
namespace {

/// More than one page of bricks a layer, and three tiers: too large to be built often.
std::vector<SmallVolume> large_volumes() {
  // Of thick slices, so that a layer has few planes
  SmallVolume wide = small_volume("1056 bricks a layer", VoxelType::uint8, {2112, 2048, 12});
  wide.description.geometry.spacing_mm = {1, 1, 16};
  return {wide, small_volume("three tiers", VoxelType::uint8, {4, 4, 4300})};
}

std::vector<GroupRun> random_runs(std::int64_t groups, std::mt19937& random) {
  std::vector<GroupRun> runs;
  const auto most = std::uniform_int_distribution<std::int64_t>(1, groups)(random);
  for (std::int64_t at = 0; at < groups;) {
    const auto count = std::uniform_int_distribution<std::int64_t>(1, most)(random);
    const std::int64_t end = std::min(at + count, groups);
    runs.emplace_back(at, end);
    at = end;
  }
  std::ranges::shuffle(runs, random);
  return runs;
}

/// The bytes of the bands that a part is made in; 0 for one that is made of whole groups.
std::uint64_t random_band(std::mt19937& random) {
  if (random() % 2 == 0) return 0;
  return 1 + random() % (std::uint64_t{1} << 17);
}

/// A volume with its file and its plan; parts are made once, in bands or without, and some of them
/// again.
class Partitioned {
 public:
  explicit Partitioned(SmallVolume volume)
      : volume_(std::move(volume)),
        plan_(parse_plan(plan_text(planned(volume_)))),
        whole_(built(volume_)) {}

  std::int64_t group_count() const { return plan_.group_count; }

  void expect_same(const std::vector<GroupRun>& runs, std::mt19937& random) {
    MemoryStorage storage;
    for (const GroupRun& run : runs) storage.files[part_name(run)] = part(run, random);
    joined(plan_, storage, runs);
    ASSERT_TRUE(*storage.files.at("a.8vo") == whole_)
        << volume_.name << " in " << runs.size() << " parts";
    ASSERT_EQ(storage.files.size(), runs.size() + 1);
  }

 private:
  FileBytes part(const GroupRun& run, std::mt19937& random) {
    const auto known = parts_.find(run);
    const bool is_made_again = random() % 16 == 0;
    if (known != parts_.end() && !is_made_again) return known->second;
    MemoryStorage storage;
    const auto threads = 1 + static_cast<int>(random() % 3);
    make_part(volume_, plan_, run, storage, "", threads, random_band(random));
    const FileBytes bytes = storage.files.at(part_name(run));
    if (known != parts_.end()) {
      EXPECT_TRUE(*bytes == *known->second) << volume_.name;
    }
    parts_[run] = bytes;
    return bytes;
  }

  SmallVolume volume_;
  BuildPlan plan_;
  std::vector<std::uint8_t> whole_;
  std::map<GroupRun, FileBytes> parts_;
};

TEST(Partition, AnyPartsInAnyOrderMakeTheFileOfABuild) {
  const SmallGroups groups(kPartGroupBytes);
  std::vector<Partitioned> volumes;
  for (SmallVolume& volume : part_volumes()) {
    const std::string name = volume.name;
    volumes.emplace_back(std::move(volume));
    EXPECT_GE(volumes.back().group_count(), 3) << name;
  }
  const std::uint64_t count = case_count(75, 10'000);
  GoalCases cases("E4", "random partitions", count);
  for (std::uint64_t i = 0; cases.next(); ++i) {
    std::mt19937 random(static_cast<std::uint32_t>(i));
    Partitioned& volume = volumes[i % volumes.size()];
    volume.expect_same(random_runs(volume.group_count(), random), random);
    if (HasFatalFailure()) FAIL() << "partition " << i;
  }
  cases.tell("all of them the bytes of a build");
}

TEST(Partition, SeveralPagesALayerAndThreeTiersMakeTheFileOfABuild) {
  for (SmallVolume& volume : large_volumes()) {
    const SmallGroups groups(1 << 10);
    Partitioned large(std::move(volume));
    std::mt19937 random(7);
    ASSERT_GE(large.group_count(), 3);
    large.expect_same(random_runs(large.group_count(), random), random);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace octavo::testing
