// System calls that fail, one after another, while a volume is built and read from a real folder;
// and calls that stop short or are interrupted, which nobody may notice.
#include <gtest/gtest.h>

#include <cerrno>
#include <random>

#include "octavo/file/verify.h"
#include "support/built_file.h"
#include "support/failing_system.h"
#include "support/goal_cases.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using namespace octavo::testing;

Volume noisy_volume(const Size3& size) {
  Volume volume;
  volume.description.type = VoxelType::uint8;
  volume.description.size = size;
  volume.voxels.resize(static_cast<std::size_t>(size.voxel_count()));
  std::mt19937_64 random(51);
  for (std::byte& voxel : volume.voxels) voxel = static_cast<std::byte>(random() % 200);
  return volume;
}

void build(const Volume& volume, const std::string& path, bool overwrite) {
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  BuildOptions options;
  options.preset = Preset::fast;
  options.overwrite = overwrite;
  options.threads = 2;
  build_file(*source, local_storage(), path, options, progress);
}

std::size_t names_beside(const std::string& path) {
  const fs::directory_iterator all(fs::path(path).parent_path());
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

struct Failure {
  const char* call;
  int code;
};

constexpr Failure kFailures[] = {
    {"open", EIO},     {"open", EMFILE}, {"pread", EIO},    {"pwrite", EIO}, {"pwrite", ENOSPC},
    {"pwrite", EFBIG}, {"fsync", EIO},   {"fsync", ENOSPC}, {"fsync", EDQUOT}, {"close", EIO},
    {"close", ENOSPC}, {"rename", EACCES}, {"rename", EIO}};

// Lets call after call of one kind fail during a build over an old file, or over none.
void fail_builds(const Failure& failure, const Volume& volume, bool has_old_file,
                 std::uint64_t& failed) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  for (std::uint64_t number = 1;; ++number) {
    fs::remove(path);
    if (has_old_file) std::ofstream(path) << "old";
    SystemFaults faults;
    faults.call = failure.call;
    faults.number = number;
    faults.code = failure.code;
    std::string message;
    set_faults(faults);
    try {
      build(volume, path, has_old_file);
    } catch (const Error& error) {
      message = error.what();
      EXPECT_EQ(error.kind(), ErrorKind::io) << message;
    }
    const SystemCounts counts = end_faults();
    const std::string what = std::string(failure.call) + " " + std::to_string(number);
    if (counts.calls < number) {
      EXPECT_EQ(message, "") << what;
      EXPECT_GT(number, 1u) << what;
      return;
    }
    ++failed;
    const std::string found = fs::exists(path) ? bytes_of_file(path) : "";
    // Nothing is tried again on a file whose sync failed.
    if (std::string(failure.call) == "fsync") {
      EXPECT_EQ(counts.later_calls, 0u) << what;
    }
    if (message.empty()) {
      // A failure that loses nothing: the descriptor of a file that was only read.
      ASSERT_STREQ(failure.call, "close") << what;
    }
    const bool is_new = message.empty() || message.find("power cut") != std::string::npos;
    if (!is_new) {
      EXPECT_EQ(found, has_old_file ? "old" : "") << what << ": " << message;
    } else {
      const auto reader = open_file(path);
      EXPECT_TRUE(read_box(*reader, box_of(volume.description.size), 0) == volume.voxels) << what;
    }
    EXPECT_EQ(names_beside(path), found.empty() ? 0u : 1u) << what << ": " << message;
    EXPECT_TRUE(message.empty() || message.find(path) == 0) << message;
  }
}

TEST(SystemCalls, EveryFailureOfABuildIsToldAndLeavesTheOldFile) {
  const Volume small = noisy_volume({40, 30, 20});
  // More than the writer holds back, and a scratch file.
  const Volume large = noisy_volume({192, 192, 72});
  GoalCases cases("D4", "kinds of failing calls, every call of a build in turn",
                  2 * std::size(kFailures));
  std::uint64_t failed = 0;
  for (const bool has_old_file : {true, false}) {
    for (const Failure& failure : kFailures) {
      if (!cases.next()) return;
      fail_builds(failure, small, has_old_file, failed);
      if (is_full_form()) fail_builds(failure, large, has_old_file, failed);
      if (HasFatalFailure()) return;
    }
  }
  cases.tell(std::to_string(failed) + " failed builds");
}

TEST(SystemCalls, EveryFailureOfAReadIsTold) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  const Volume volume = noisy_volume({70, 30, 20});
  build(volume, path, false);
  for (const Failure& failure : {Failure{"open", EACCES}, Failure{"pread", EIO}}) {
    for (std::uint64_t number = 1;; ++number) {
      SystemFaults faults;
      faults.call = failure.call;
      faults.number = number;
      faults.code = failure.code;
      set_faults(faults);
      std::string message;
      try {
        NoProgress progress;
        const bool is_sound =
            verify_file(open_byte_source(local_storage(), path), {}, progress).is_sound();
        EXPECT_TRUE(is_sound) << "a disk error is no damage of the file";
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::io) << error.what();
        message = error.what();
      }
      if (end_faults().calls < number) {
        EXPECT_GT(number, 1u);
        break;
      }
      EXPECT_EQ(message.find(path + ": cannot "), 0u) << failure.call << " " << number << message;
    }
  }
}

TEST(SystemCalls, NobodyNoticesShortAndInterruptedCalls) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  const Volume volume = noisy_volume({192, 192, 72});
  build(volume, path, false);
  const std::string whole = bytes_of_file(path);
  GoalCases cases("D4", "builds and reads with short and interrupted calls", case_count(3, 200));
  std::uint64_t interrupted = 0;
  std::uint64_t cut = 0;
  while (cases.next()) {
    SystemFaults faults;
    faults.is_rough = true;
    faults.number = cases.done();
    set_faults(faults);
    build(volume, path, true);
    const auto reader = open_file(path);
    const auto voxels = read_box(*reader, box_of(volume.description.size), 0);
    const SystemCounts counts = end_faults();
    ASSERT_TRUE(voxels == volume.voxels);
    ASSERT_TRUE(bytes_of_file(path) == whole);
    interrupted += counts.interrupted_calls;
    cut += counts.short_calls;
  }
  cases.tell(std::to_string(interrupted) + " calls interrupted and " + std::to_string(cut) +
             " cut short");
  EXPECT_GT(interrupted, 10u);
  EXPECT_GT(cut, 10u);
}

}  // namespace
}  // namespace octavo
