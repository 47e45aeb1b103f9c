// Parts and joins by processes of their own: of different instruction sets, and killed at any time.
// This process never touches a codec, so that it can be forked.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <set>

#include "octavo/builder/group_reader.h"
#include "octavo/codec/simd_level.h"
#include "octavo/dist/join_steps.h"
#include "octavo/dist/plan_text.h"
#include "support/built_file.h"
#include "support/goal_cases.h"
#include "support/part_volumes.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// How a process ends: by itself, or killed after a time.
struct Ending {
  std::chrono::microseconds killed_after{-1};
  std::string level = "";  ///< OCTAVO_SIMD
};

/// Runs `work` in a process. Returns whether it came to its end.
bool runs_through(const std::function<void()>& work, const Ending& ending = {}) {
  std::fflush(nullptr);
  const pid_t process = ::fork();
  if (process == 0) {
    if (!ending.level.empty()) ::setenv("OCTAVO_SIMD", ending.level.c_str(), 1);
    try {
      work();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      ::_exit(1);
    }
    ::_exit(0);
  }
  if (ending.killed_after.count() >= 0) {
    ::usleep(static_cast<useconds_t>(ending.killed_after.count()));
    ::kill(process, SIGKILL);
  }
  int status = 0;
  ::waitpid(process, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

/// One volume in a folder: its plan, its file as a build makes it, and its groups.
class PartFolder {
 public:
  explicit PartFolder(SmallVolume volume) : volume_(std::move(volume)) {
    const bool is_built = runs_through([&] {
      const SmallGroups groups(kPartGroupBytes);
      NoProgress progress;
      build_file(*volume_.open(), local_storage(), file("whole"), volume_.options, progress);
      const BuildPlan plan = planned(volume_);
      write_text(file("plan"), plan_text(plan));
      write_text(file("count"), std::to_string(plan.group_count));
    });
    EXPECT_TRUE(is_built) << volume_.name;
    whole_ = bytes_of_file(file("whole"));
    group_count_ = std::strtoll(bytes_of_file(file("count")).c_str(), nullptr, 10);
  }

  std::string file(const std::string& name) const { return folder_.file(name); }
  const std::string& whole() const { return whole_; }
  std::int64_t group_count() const { return group_count_; }
  std::string part(const GroupRun& run) const { return file(part_name(run)); }

  bool make(const GroupRun& run, const Ending& ending = {}) const {
    return runs_through(
        [&] {
          const SmallGroups groups(kPartGroupBytes);
          make_part(volume_, plan(), run, local_storage(), file(""));
        },
        ending);
  }

  bool join(const std::vector<GroupRun>& runs, const Ending& ending = {}) const {
    return runs_through(
        [&] {
          const SmallGroups groups(kPartGroupBytes);
          joined(plan(), local_storage(), runs, file("a.8vo"), file(""));
        },
        ending);
  }

  bool consume(const std::vector<GroupRun>& runs, const Ending& ending = {}) const {
    return runs_through(
        [&] {
          const SmallGroups groups(kPartGroupBytes);
          std::vector<std::string> paths;
          for (const GroupRun& run : runs) paths.push_back(part(run));
          NoProgress progress;
          consume_parts(plan(), paths, local_storage(), file("a.8vo"), true, {.threads = 1},
                        progress);
        },
        ending);
  }

  /// The names in the folder, but for those that every folder has.
  std::set<std::string> names() const {
    std::set<std::string> all;
    for (const auto& entry : fs::directory_iterator(file(""))) all.insert(entry.path().filename());
    for (const char* const known : {"whole", "plan", "count"}) all.erase(known);
    return all;
  }

 private:
  BuildPlan plan() const { return parse_plan(bytes_of_file(file("plan"))); }

  ScratchFolder folder_;
  SmallVolume volume_;
  std::string whole_;
  std::int64_t group_count_ = 0;
};

std::vector<std::string> simd_levels() {
  std::vector<std::string> levels = {"scalar"};
  for (const char* const level : {"sse4", "avx2", "avx512", "neon"}) {
    if (simd_targets_of(level) != 0) levels.emplace_back(level);
  }
  return levels;
}

/// How long `work` takes at most, about.
std::chrono::microseconds time_of(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start);
}

std::chrono::microseconds random_part(std::chrono::microseconds whole, std::mt19937& random) {
  return std::chrono::microseconds(
      std::uniform_int_distribution<std::int64_t>(0, whole.count())(random));
}

TEST(PartProcesses, PartsOfAnyInstructionSetMakeOneFile) {
  const std::vector<std::string> levels = simd_levels();
  std::size_t level = 0;
  std::size_t number = 0;
  for (SmallVolume& volume : part_volumes()) {
    if (number++ % 3 != 0 && !is_full_form()) continue;
    const std::string name = volume.name;
    const PartFolder folder(std::move(volume));
    std::vector<GroupRun> runs;
    for (std::int64_t group = 0; group < folder.group_count(); ++group) {
      runs.emplace_back(group, group + 1);
      ASSERT_TRUE(folder.make(runs.back(), {.level = levels[level++ % levels.size()]})) << name;
    }
    ASSERT_TRUE(folder.join(runs, {.level = levels[level++ % levels.size()]})) << name;
    ASSERT_TRUE(bytes_of_file(folder.file("a.8vo")) == folder.whole()) << name;
  }
}

TEST(PartProcesses, AKilledPartIsMadeAgainAlike) {
  const PartFolder folder(part_volumes()[1]);
  const GroupRun run = {1, 3};
  std::chrono::microseconds time{};
  ASSERT_TRUE(folder.make(run));
  time = time_of([&] { folder.make(run); });
  const std::string part = bytes_of_file(folder.part(run));
  fs::remove(folder.part(run));
  GoalCases cases("D8", "killed parts", case_count(10, 200));
  std::uint64_t killed = 0;
  for (std::uint64_t i = 0; cases.next(); ++i) {
    std::mt19937 random(static_cast<std::uint32_t>(i));
    if (!folder.make(run, {.killed_after = random_part(time, random)})) ++killed;
    if (fs::exists(folder.part(run))) {
      ASSERT_TRUE(bytes_of_file(folder.part(run)) == part) << i;
      fs::remove(folder.part(run));
    }
    ASSERT_TRUE(folder.make(run)) << i;
    ASSERT_TRUE(bytes_of_file(folder.part(run)) == part) << i;
    ASSERT_EQ(folder.names(), std::set<std::string>{part_name(run)}) << i;
    fs::remove(folder.part(run));
  }
  cases.tell(std::to_string(killed) + " of them before their end, all made again alike");
  EXPECT_GT(killed, 0U);
}

TEST(PartProcesses, AKilledJoinIsDoneAgainAlike) {
  const PartFolder folder(part_volumes()[0]);
  const std::vector<GroupRun> runs = {{0, 2}, {2, folder.group_count()}};
  std::vector<std::string> parts;
  for (const GroupRun& run : runs) {
    ASSERT_TRUE(folder.make(run));
    parts.push_back(bytes_of_file(folder.part(run)));
  }
  const std::chrono::microseconds time = time_of([&] { folder.join(runs); });
  fs::remove(folder.file("a.8vo"));
  GoalCases cases("D8", "killed joins", case_count(10, 100));
  std::uint64_t killed = 0;
  for (std::uint64_t i = 0; cases.next(); ++i) {
    std::mt19937 random(static_cast<std::uint32_t>(i));
    const bool consumes = i % 2 == 1;
    const auto join = [&](const Ending& ending) {
      return consumes ? folder.consume(runs, ending) : folder.join(runs, ending);
    };
    if (!join({.killed_after = random_part(time * (consumes ? 2 : 1), random)})) ++killed;
    if (fs::exists(folder.file("a.8vo"))) {
      ASSERT_TRUE(bytes_of_file(folder.file("a.8vo")) == folder.whole()) << i;
      if (!consumes) fs::remove(folder.file("a.8vo"));
    }
    const bool is_whole = consumes && fs::exists(folder.file("a.8vo"));
    if (!is_whole) {
      ASSERT_TRUE(join({})) << i;
    }
    ASSERT_TRUE(bytes_of_file(folder.file("a.8vo")) == folder.whole()) << i;
    // All stand again for the next one
    for (const std::string& name : folder.names()) fs::remove(folder.file(name));
    for (std::size_t part = 0; part < runs.size(); ++part) {
      write_text(folder.part(runs[part]), parts[part]);
    }
  }
  cases.tell(std::to_string(killed) + " of them before their end, all done again alike");
  EXPECT_GT(killed, 0U);
}

}  // namespace
}  // namespace octavo::testing
