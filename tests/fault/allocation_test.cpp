// Memory that runs out: every allocation of a build, an opening, a read and a verification fails in
// turn. The answer is an error, nothing is kept, and no part of a file is left.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <new>
#include <span>
#include <thread>

#include "octavo/file/verify.h"
#include "support/built_file.h"
#include "support/counted_memory.h"
#include "support/goal_cases.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using namespace octavo::testing;

enum class Outcome { done, out_of_memory, other };

// Runs `action` while allocation `number` fails; `failed` tells whether it came to that.
Outcome run_failing(const std::function<void()>& action, std::uint64_t number, bool and_all_later,
                    bool& failed) {
  Outcome outcome = Outcome::done;
  fail_allocation(number, and_all_later);
  try {
    action();
  } catch (const std::bad_alloc&) {
    outcome = Outcome::out_of_memory;
  } catch (const Error& error) {
    const bool is_memory = error.kind() == ErrorKind::out_of_memory;
    outcome = is_memory ? Outcome::out_of_memory : Outcome::other;
  } catch (...) {
    outcome = Outcome::other;
  }
  failed = stop_failing();
  return outcome;
}

// Whether no more memory is held than `bytes`, once threads that have something to drop come to it.
bool falls_to(std::size_t bytes, int looks) {
  for (int i = 0; i < looks; ++i) {
    if (live_bytes() <= bytes) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

// Threads keep buffers for their next work, so that some runs end with more memory held than they
// began with. What leaks grows every time.
bool grows_every_time(const std::function<void()>& action, std::uint64_t number,
                      bool and_all_later) {
  constexpr int kRuns = 12;
  // Threads that drop late are waited for behind the last run alone: the next one does not count
  // what they hold when it begins.
  constexpr int kLooks = 20;
  constexpr int kLastLooks = 4000;
  for (int i = 1; i <= kRuns; ++i) {
    const std::size_t before = live_bytes();
    bool failed = false;
    run_failing(action, number, and_all_later, failed);
    if (falls_to(before, i < kRuns ? kLooks : kLastLooks)) return false;
  }
  return true;
}

std::size_t open_descriptors() {
  const fs::directory_iterator all("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

// Fails one allocation of `action` after another, or every `step`-th.
void fail_every_allocation(const std::string& name, const std::function<void()>& action,
                           std::uint64_t step, const std::function<void()>& check) {
  // What is made once and kept is made before.
  std::uint64_t count = 0;
  for (int i = 0; i < 3; ++i) {
    const std::uint64_t first = allocation_count();
    action();
    count = allocation_count() - first;
  }
  const std::size_t descriptors = open_descriptors();
  GoalCases cases("C3", "allocations failed in turn", count / step + 1);
  const std::size_t before = live_bytes();
  std::uint64_t rejected = 0;
  for (std::uint64_t k = 1; cases.next(); k += step) {
    bool is_over = false;
    for (const bool and_all_later : {false, true}) {
      bool failed = false;
      const Outcome outcome = run_failing(action, k, and_all_later, failed);
      is_over = is_over || !failed;
      ASSERT_NE(outcome, Outcome::other) << name << ", allocation " << k;
      ASSERT_TRUE(failed || outcome == Outcome::done) << name << ", allocation " << k;
      if (outcome == Outcome::out_of_memory) ++rejected;
      ASSERT_FALSE(live_bytes() > before && grows_every_time(action, k, and_all_later))
          << name << ", allocation " << k << (and_all_later ? " and all later" : "");
      ASSERT_EQ(open_descriptors(), descriptors) << name << ", allocation " << k;
      if (outcome == Outcome::out_of_memory) check();
    }
    if (is_over) {
      cases.finish();
      break;
    }
  }
  cases.tell("each alone and with all later ones");
  EXPECT_GT(rejected, 3u);
}

Volume small_volume(VolumeKind kind, VoxelType type) {
  Volume volume;
  volume.description.kind = kind;
  volume.description.type = type;
  volume.description.size = {66, 5, 3};
  with_voxel_type(type, [&](auto id) {
    using T = typename decltype(id)::type;
    std::vector<T> voxels;
    std::uint32_t state = 1;
    for (int i = 0; i < 66 * 5 * 3; ++i) {
      state = state * 1664525u + 1013904223u;
      const auto smooth = static_cast<std::uint32_t>(i % 66 / 8);
      const bool is_label = kind == VolumeKind::labels;
      voxels.push_back(static_cast<T>(is_label ? smooth / 3 : smooth * 9 + (state >> 28)));
    }
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
  });
  return volume;
}

struct Build {
  std::string name;
  VolumeKind kind = VolumeKind::grey;
  VoxelType type = VoxelType::uint8;
  Preset preset = Preset::small;
  double max_error = 0;
};

const Build kBuilds[] = {{.name = "small uint8", .type = VoxelType::uint8},
                         {.name = "fast int16", .type = VoxelType::int16, .preset = Preset::fast},
                         {.name = "max error int16", .type = VoxelType::int16, .max_error = 2},
                         {.name = "float32 within 0.1", .type = VoxelType::float32,
                          .max_error = 0.1},
                         {.name = "labels", .kind = VolumeKind::labels,
                          .type = VoxelType::uint16}};

void build(const Build& how, const Volume& volume, const std::string& path) {
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  BuildOptions options;
  options.kind = how.kind;
  options.preset = how.preset;
  options.max_error = how.max_error;
  options.overwrite = true;
  options.threads = 2;
  build_file(*source, local_storage(), path, options, progress);
}

TEST(Allocation, ABuildThatRunsOutOfMemoryLeavesTheOldFile) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  for (const Build& how : kBuilds) {
    const Volume volume = small_volume(how.kind, how.type);
    const auto action = [&] { build(how, volume, path); };
    action();
    const std::string whole = bytes_of_file(path);
    const std::uint64_t step = is_full_form() ? 1 : 61;
    fail_every_allocation("build, " + how.name, action, step, [&] {
      const fs::directory_iterator all(fs::path(path).parent_path());
      ASSERT_EQ(std::distance(begin(all), end(all)), 1) << how.name;
      ASSERT_EQ(bytes_of_file(path), whole) << how.name;
    });
    if (HasFatalFailure()) return;
  }
}

TEST(Allocation, AReaderThatRunsOutOfMemorySaysSo) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  for (const Build& how : kBuilds) {
    const Volume volume = small_volume(how.kind, how.type);
    build(how, volume, path);
    const auto whole = [&] {
      const auto reader = open_file(path);
      return read_box(*reader, box_of(volume.description.size), 0);
    };
    const std::vector<std::byte> voxels = whole();
    const std::uint64_t step = is_full_form() ? 1 : 3;
    fail_every_allocation("open and read, " + how.name,
                          [&] { ASSERT_TRUE(whole() == voxels); }, step, [] {});
    const auto check = [&] {
      NoProgress progress;
      const VerifyReport report =
          verify_file(open_byte_source(local_storage(), path), {}, progress);
      ASSERT_TRUE(report.is_sound());
    };
    fail_every_allocation("verify, " + how.name, check, step, [] {});
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace octavo
