// A disk that fails while parts are made and joined: each call in turn, and writes that end half
// way. No name holds anything but a whole part or a whole file, and the next try makes the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/dist/join_steps.h"
#include "support/built_file.h"
#include "support/goal_cases.h"
#include "support/part_volumes.h"
#include "support/stopping_progress.h"

namespace octavo::testing {
namespace {

using Files = std::map<std::string, FileBytes>;

/// Runs `work` on what a storage holds while call number `call` fails, and then again while none
/// does; `check` looks at what is left in between.
void fail_call(MemoryStorage& storage, std::size_t call, bool is_dying,
               const std::function<void()>& work, const std::function<void()>& check) {
  storage.calls.clear();
  storage.fail_at = call;
  storage.is_dying = is_dying;
  storage.has_failed = false;
  try {
    work();
    EXPECT_FALSE(storage.has_failed) << "call " << call << " failed unnoticed";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io) << error.what();
    EXPECT_FALSE(error.path().empty()) << error.what();
  }
  storage.fail_at = 0;
  storage.is_dying = false;
  storage.has_failed = false;
  check();
}

std::size_t calls_of(MemoryStorage& storage, const std::function<void()>& work) {
  storage.calls.clear();
  work();
  return storage.calls.size();
}

TEST(PartFaults, WhateverCallFailsAPartIsWholeOrNotThere) {
  const SmallGroups groups(kPartGroupBytes);
  const SmallVolume volume = small_volume("faults", VoxelType::int16, {13, 10, 300});
  const BuildPlan plan = planned(volume);
  const GroupRun run = {1, 3};
  MemoryStorage storage;
  const auto make = [&] { make_part(volume, plan, run, storage); };
  const std::size_t calls = calls_of(storage, make);
  const std::vector<std::uint8_t> part = *storage.files.at(part_name(run));
  for (const bool is_dying : {false, true}) {
    GoalCases cases("D8", "failing calls of a part", calls);
    for (std::size_t call = 1; cases.next(); ++call) {
      storage.files.clear();
      fail_call(storage, call, is_dying, make, [&] {
        const auto found = storage.files.find(part_name(run));
        if (found == storage.files.end()) return;
        ASSERT_TRUE(*found->second == part) << call;
      });
      make();
      ASSERT_TRUE(*storage.files.at(part_name(run)) == part) << call;
      ASSERT_EQ(storage.files.size(), 1U) << call;
    }
  }
}

/// Of changed voxels, whose bricks wait in a scratch file: several rows of several bricks.
TEST(PartFaults, WhateverCallFailsAPartInBandsIsThatOfWholeGroupsOrNotThere) {
  const SmallGroups groups(kPartGroupBytes);
  for (const VoxelType type : {VoxelType::int16, VoxelType::float32}) {
    SmallVolume volume = small_volume("bands", type, {100, 70, 130});
    volume.options.max_error = is_integer(type) ? 2 : 0.2;
    const BuildPlan plan = planned(volume);
    const GroupRun run = {1, 3};
    MemoryStorage storage;
    make_part(volume, plan, run, storage);
    EXPECT_EQ(std::ranges::count(storage.calls, "create_scratch"), 0);
    const std::vector<std::uint8_t> part = *storage.files.at(part_name(run));
    storage.files.clear();
    const auto make = [&] { make_part(volume, plan, run, storage, "", 2, 1); };
    const std::size_t calls = calls_of(storage, make);
    ASSERT_TRUE(*storage.files.at(part_name(run)) == part);
    EXPECT_GT(std::ranges::count(storage.calls, "create_scratch"), 0);
    for (std::size_t call = 1; call <= calls; call += 1 + calls / 5) {
      storage.files.clear();
      fail_call(storage, call, false, make, [&] {
        const auto found = storage.files.find(part_name(run));
        if (found == storage.files.end()) return;
        ASSERT_TRUE(*found->second == part) << call;
      });
      ASSERT_LE(storage.files.size(), 1U) << call;
    }
  }
}

TEST(PartFaults, WhateverCallFailsAJoinedFileIsWholeOrNotThere) {
  const SmallGroups groups(kPartGroupBytes);
  SmallVolume volume = small_volume("faults", VoxelType::int16, {13, 10, 300});
  volume.options.has_thumbnail = true;
  const BuildPlan plan = planned(volume);
  const std::vector<GroupRun> runs = {{0, 2}, {2, 3}, {3, plan.group_count}};
  const std::vector<std::uint8_t> whole = built(volume);
  MemoryStorage storage;
  for (const GroupRun& run : runs) make_part(volume, plan, run, storage);
  const Files parts = copied(storage.files);

  const auto join = [&] { joined(plan, storage, runs); };
  const auto in_steps = [&] {
    NoProgress progress;
    lay_out_join(plan, open_parts(storage, runs), storage, "a.8vo", false, {.threads = 1},
                 progress);
    for (const auto& part : open_parts(storage, runs)) {
      copy_part(plan, part, storage, "a.8vo", false, progress);
    }
    seal_join(plan, storage, "a.8vo", false, {.threads = 1}, progress);
  };
  for (const std::function<void()>& work : {std::function<void()>(join), {in_steps}}) {
    storage.files = copied(parts);
    const std::size_t calls = calls_of(storage, work);
    for (const bool is_dying : {false, true}) {
      GoalCases cases("D8", "failing calls of a join", calls);
      for (std::size_t call = 1; cases.next(); ++call) {
        storage.files = copied(parts);
        bool is_there = false;
        fail_call(storage, call, is_dying, work, [&] {
          const auto found = storage.files.find("a.8vo");
          is_there = found != storage.files.end();
          if (is_there) {
            ASSERT_TRUE(*found->second == whole) << call;
          }
          for (const auto& [name, bytes] : parts) {
            ASSERT_TRUE(*storage.files.at(name) == *bytes) << name << ", call " << call;
          }
        });
        if (is_there) storage.remove("a.8vo");
        work();
        ASSERT_TRUE(*storage.files.at("a.8vo") == whole) << call;
      }
    }
  }
}

TEST(PartFaults, TwoWritersOfOnePartDoNoHarm) {
  const SmallGroups groups(kPartGroupBytes);
  const SmallVolume volume = small_volume("twice", VoxelType::int16, {33, 20, 300});
  const BuildPlan plan = planned(volume);
  const GroupRun run = {0, plan.group_count};
  const ScratchFolder folder;
  const auto make = [&] {
    for (int i = 0; i < 5; ++i) make_part(volume, plan, run, local_storage(), folder.file(""));
  };
  std::thread other(make);
  make();
  other.join();
  MemoryStorage storage;
  make_part(volume, plan, run, storage);
  const std::vector<std::uint8_t>& alone = *storage.files.at(part_name(run));
  EXPECT_EQ(bytes_of_file(folder.file(part_name(run))), std::string(alone.begin(), alone.end()));
  EXPECT_EQ(local_storage().list(folder.file("")).size(), 1U) << "something is left behind";
}

TEST(PartFaults, APartThatIsStoppedLeavesNothing) {
  const SmallGroups groups(kPartGroupBytes);
  const SmallVolume volume = small_volume("stopped", VoxelType::int16, {33, 20, 300});
  const BuildPlan plan = planned(volume);
  MemoryStorage storage;
  for (const int answered : {0, 1, 40, 130}) {
    StoppingProgress progress(answered);
    try {
      build_part(plan, *volume.open(), 0, plan.group_count, storage, "part", {.threads = 1},
                 progress);
      ADD_FAILURE() << "nobody stopped it after " << answered;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled) << error.what();
    }
    EXPECT_TRUE(storage.files.empty()) << answered;
  }
}

}  // namespace
}  // namespace octavo::testing
