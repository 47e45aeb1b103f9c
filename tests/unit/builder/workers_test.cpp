#include "octavo/builder/workers.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace octavo
