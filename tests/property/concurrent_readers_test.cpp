// Many readers at once: threads on one handle, and processes on a name whose file is replaced all
// the time.
#include <gtest/gtest.h>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <new>
#include <random>
#include <span>
#include <thread>

#include "support/built_file.h"
#include "support/goal_cases.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using Random = std::mt19937_64;

// Voxels that tell their version: a pattern that it shifts, and noise.
Volume volume_of(std::uint64_t version, const Size3& size) {
  Volume volume;
  volume.description.type = VoxelType::uint16;
  volume.description.size = size;
  std::vector<std::uint16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  Random random(version);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::uint16_t>(i / 64 + 7 * version + random() % 16);
  }
  const auto bytes = std::as_bytes(std::span(voxels));
  volume.voxels.assign(bytes.begin(), bytes.end());
  return volume;
}

// Of many small bricks, so that the most reads and evictions take place in a second.
constexpr Size3 kBar{600, 12, 10};

std::int64_t below(Random& random, std::int64_t n) {
  return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
}

Box random_box(const Size3& size, Random& random) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[axis] = below(random, size[axis]);
    box.hi[axis] = box.lo[axis] + 1 + below(random, std::min<std::int64_t>(20, size[axis] -
                                                                                  box.lo[axis]));
  }
  return box;
}

// Three bricks fit: threads put out what others are about to read.
std::shared_ptr<FileReader> open_with_little_cache(const std::string& path) {
  ReaderOptions options;
  options.cache_bytes = 3 * sizeof(std::uint16_t) * 64 * kBar.y * kBar.z;
  return FileReader::open(open_byte_source(local_storage(), path), options);
}

TEST(ConcurrentReaders, SixteenThreadsOnOneHandleReadWhatOneReads) {
  constexpr int kThreads = 16;
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  build_volume(volume_of(1, kBar), path, 2);
  const auto serial = open_file(path);
  std::vector<std::vector<std::byte>> levels;
  for (int level = 0; level < serial->levels().count(); ++level) {
    levels.push_back(read_box(*serial, box_of(serial->levels().size(level)), level));
  }

  const auto shared = open_with_little_cache(path);
  const std::uint64_t each = case_count(60, 1'000'000);
  GoalCases cases("E3", "random reads by 16 threads on one handle", kThreads * each);
  std::atomic<std::uint64_t> wrong = 0;
  std::atomic<bool> is_over = false;
  std::mutex counting;
  const auto read_some = [&](std::uint64_t seed) {
    Random random(seed);
    for (std::uint64_t i = 0; i < each && !is_over; ++i) {
      {
        const std::lock_guard lock(counting);
        if (!cases.next()) is_over = true;
        if (is_over) return;
      }
      const int level = static_cast<int>(below(random, shared->levels().count()));
      const Size3& size = shared->levels().size(level);
      const Box box = random_box(size, random);
      const auto found = read_box(*shared, box, level);
      if (found != crop(levels[static_cast<std::size_t>(level)], size, 2, box)) ++wrong;
    }
  };
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < kThreads; ++i) threads.emplace_back(read_some, i + 1);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0u);
}

// What the processes share.
struct Board {
  std::atomic<bool> is_over = false;
  std::atomic<std::uint64_t> reads = 0;
  std::atomic<std::uint64_t> replaced_while_reading = 0;
};

constexpr Size3 kSize{70, 40, 30};
constexpr std::uint64_t kVersions = 8;

// Opens and reads in small boxes until all is over; every handle sees one version. Returns the
// exit status.
int read_until_over(const std::string& path, const std::vector<Volume>& versions, Board& board,
                    std::uint64_t seed) {
  Random random(seed);
  while (!std::filesystem::exists(path) && !board.is_over) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  while (!board.is_over) {
    const auto reader = open_file(path);
    const auto first = read_box(*reader, box_of(kSize), 0);
    const auto version = std::find_if(
        versions.begin(), versions.end(), [&](const Volume& v) { return v.voxels == first; });
    if (version == versions.end()) return 1;
    // The same handle goes on after its file lost the name; a new one, without a cache.
    ReaderOptions options;
    options.cache_bytes = 0;
    const auto again = FileReader::open(open_byte_source(local_storage(), path), options);
    const std::uint64_t id = again->build_id();
    const auto whole = read_box(*again, box_of(kSize), 0);
    for (int i = 0; i < 20; ++i) {
      const Box box = random_box(kSize, random);
      if (read_box(*again, box, 0) != crop(whole, kSize, 2, box)) return 2;
    }
    ++board.reads;
    if (open_file(path)->build_id() != id) ++board.replaced_while_reading;
  }
  return 0;
}

TEST(ConcurrentReaders, EachHandleSeesOneFileWhileBuildsReplaceIt) {
  constexpr int kProcesses = 8;
  const ScratchFolder folder;
  const std::string path = folder.file("a.8vo");
  std::vector<Volume> versions;
  for (std::uint64_t i = 0; i < kVersions; ++i) versions.push_back(volume_of(i + 1, kSize));
  void* const page = ::mmap(nullptr, sizeof(Board), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(page, MAP_FAILED);
  auto& board = *new (page) Board;

  const auto build_version = [&](const Volume& volume) {
    const auto source = make_memory_source(volume.description, volume.voxels);
    NoProgress progress;
    BuildOptions options;
    options.preset = Preset::fast;
    options.overwrite = true;
    options.threads = 1;
    build_file(*source, local_storage(), path, options, progress);
  };
  // Before the first build, whose threads a new process would lack; readers wait for its file.
  std::vector<pid_t> readers;
  for (int i = 0; i < kProcesses; ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      // The builds are to go on beside them.
      [[maybe_unused]] const int niceness = ::nice(15);
      int status = 3;
      try {
        status = read_until_over(path, versions, board, static_cast<std::uint64_t>(i + 1));
      } catch (const std::exception& error) {
        std::fprintf(stderr, "reader %d: %s\n", i, error.what());
      }
      ::_exit(status);
    }
    readers.push_back(child);
  }

  GoalCases cases("E3", "replacements under 8 reading processes", case_count(15, 1000));
  while (cases.next()) build_version(versions[cases.done() % kVersions]);
  board.is_over = true;
  for (const pid_t reader : readers) {
    int status = 0;
    EXPECT_EQ(::waitpid(reader, &status, 0), reader);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }
  cases.tell(std::to_string(board.reads) + " whole reads, " +
             std::to_string(board.replaced_while_reading) + " of a file replaced meanwhile");
  EXPECT_GT(board.reads, 0u);
  ::munmap(page, sizeof(Board));
}

}  // namespace
}  // namespace octavo
