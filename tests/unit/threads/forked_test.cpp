#include "octavo/threads/forked.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <stdexcept>
#include <thread>
#include <vector>

#include "octavo/threads/arena.h"
#include "octavo/threads/ordered_pipeline.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/parallel_sort.h"
#include "octavo/threads/per_thread.h"
#include "octavo/threads/started_work.h"

namespace octavo {
namespace {

/// The sum of 0 .. 999, of loops in loops in an arena.
std::int64_t sum_of_loops() {
  std::int64_t sum = 0;
  run_in_arena(3, [&] {
    PerThread<std::int64_t> parts;
    parallel_for(0, 10, [&](int i) {
      run_isolated([&] { parallel_for(0, 100, [&](int k) { parts.local() += 100 * i + k; }); });
    });
    for (const std::int64_t part : parts) sum += part;
  });
  return sum;
}

/// What a forked process finds wrong, as its exit code.
int faults_of_loops() {
  int faults = 0;
  if (has_threads() || arena_threads() != 1) faults |= 1;
  if (sum_of_loops() != 499500) faults |= 2;
  std::vector<int> values(20000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<int>(i * 7919 % 20011);
  parallel_sort(values);
  if (!std::is_sorted(values.begin(), values.end())) faults |= 4;
  int turns = 0;
  const auto failing = [&turns](std::int64_t i, std::int64_t) {
    ++turns;
    if (i == 1) throw std::runtime_error("failed");
  };
  try {
    run_each(4, LoopWork(failing));
    faults |= 8;
  } catch (const std::runtime_error&) {
    if (turns != 4) faults |= 8;
  }
  int kept = 0;
  ordered_pipeline(9, 4, [](std::size_t i) { return static_cast<int>(i); },
                   [&](int made) { kept = made == kept ? kept + 1 : -1; });
  if (kept != 9) faults |= 16;
  StartedWork work;
  work.start([&] { ++kept; });
  work.wait();
  work.wait();
  work.start([&] { ++kept; });
  work.cancel();
  work.wait();
  if (kept != 10) faults |= 32;
  return faults;
}

TEST(Forked, LoopsRunOnTheCallingThreadWhateverOthersDidAtTheFork) {
  EXPECT_TRUE(has_threads());
  std::atomic<bool> is_over = false;
  std::vector<std::jthread> others;
  for (int i = 0; i < 3; ++i) {
    others.emplace_back([&] {
      while (!is_over) EXPECT_EQ(sum_of_loops(), 499500);
    });
  }
  for (int i = 0; i < 50; ++i) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) _exit(faults_of_loops());
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0);
  }
  is_over = true;
  others.clear();
  EXPECT_TRUE(has_threads());
  EXPECT_EQ(sum_of_loops(), 499500);
}

}  // namespace
}  // namespace octavo
