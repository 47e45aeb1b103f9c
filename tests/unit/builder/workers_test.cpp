#include "octavo/builder/workers.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <atomic>
#include <thread>
#include <vector>

namespace octavo {
namespace {

// Keeps all threads of TBB in an arena of its own, as one does that spins there.
class BusyThreads {
 public:
  explicit BusyThreads(int threads)
      : limit_(tbb::global_control::max_allowed_parallelism,
               static_cast<std::size_t>(threads) + 1),
        arena_(threads, 0) {
    for (int i = 0; i < threads; ++i) {
      arena_.enqueue([this] {
        ++held_;
        while (!is_free_) std::this_thread::yield();
        --held_;
      });
    }
    while (held_ < threads) std::this_thread::yield();
  }
  ~BusyThreads() {
    is_free_ = true;
    while (held_ > 0) std::this_thread::yield();
  }

 private:
  tbb::global_control limit_;
  tbb::task_arena arena_;
  std::atomic<int> held_{0};
  std::atomic<bool> is_free_{false};
};

TEST(Workers, WaitingRunsInOrderWhatTheThreadsLeaveLying) {
  Workers workers(1);
  const BusyThreads busy(1);
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<int> done;
  for (int i = 0; i < 3; ++i) {
    workers.start([&, i] {
      const std::lock_guard lock(mutex);
      done.push_back(i);
      changed.notify_all();
    });
  }
  std::unique_lock lock(mutex);
  workers.wait(changed, lock, [&] { return done.size() == 3; });
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2}));
  EXPECT_FALSE(workers.help());
}

TEST(Workers, ThreadsRunWorkThatNobodyWaitsFor) {
  Workers workers(2);
  std::atomic<int> left{20};
  for (int i = 0; i < 20; ++i) workers.start([&] { --left; });
  while (left > 0) std::this_thread::yield();
  EXPECT_EQ(left, 0);
}

TEST(Workers, WorkMayOutliveTheWorkersThatHadNoThreadForIt) {
  const BusyThreads busy(1);
  std::atomic<int> done{0};
  {
    Workers workers(1);
    workers.start([&] { ++done; });
    EXPECT_TRUE(workers.help());
  }
  EXPECT_EQ(done, 1);
}

// What a forked process finds wrong, as its exit code.
int faults_of_workers() {
  Workers workers(4);
  if (workers.count() != 1) return 1;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<int> done;
  const int made = workers.run([&] {
    for (int i = 0; i < 3; ++i) workers.start([&, i] { done.push_back(i); });
    return 5;
  });
  if (made != 5 || !done.empty()) return 2;
  std::unique_lock lock(mutex);
  workers.wait(changed, lock, [&] { return done.size() == 3; });
  return done == std::vector<int>{0, 1, 2} && !workers.help() ? 0 : 3;
}

TEST(Workers, OfAForkedProcessAreTheThreadThatWaits) {
  const BusyThreads busy(2);
  Workers of_the_parent(2);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) _exit(faults_of_workers());
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace octavo
