#include "octavo/threads/arena.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>
#include <vector>

#include "octavo/threads/parallel_for.h"

namespace octavo {
namespace {

TEST(Arena, HasTheThreadsThatAreAskedFor) {
  const int outside = arena_threads();
  EXPECT_GE(outside, 1);
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    run_in_arena(threads, [&] { EXPECT_EQ(arena_threads(), threads); });
  }
}

TEST(Arena, HasAllThreadsWhereNoneAreAskedFor) {
  const int outside = arena_threads();
  run_in_arena(0, [&] { EXPECT_EQ(arena_threads(), outside); });
}

TEST(ArenaDeathTest, TakesNoMoreThreadsThanTheProcessMayUseAndSaysNothing) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  const auto ask_for_many = [] {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 2);
    run_in_arena(7, [] {
      parallel_for(0, 100, [](int) {});
      std::exit(arena_threads());
    });
  };
  EXPECT_EXIT(ask_for_many(), testing::ExitedWithCode(2), "^$");
}

TEST(Arena, HandsOnWhatIsThrown) {
  EXPECT_THROW(run_in_arena(2, [] { throw std::runtime_error("failed"); }), std::runtime_error);
  EXPECT_THROW(run_isolated([] { throw std::runtime_error("failed"); }), std::runtime_error);
}

TEST(Arena, IsForOneCallerAlone) {
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 4);
  std::atomic<int> wrong = 0;
  const auto call = [&](int threads) {
    for (int i = 0; i < 50; ++i) {
      std::atomic<int> turns = 0;
      std::atomic<int> inside = 0;
      run_in_arena(threads, [&] {
        if (arena_threads() != threads) ++wrong;
        parallel_for(0, 8, [&](int) {
          if (++inside > threads) ++wrong;
          // Another arena, though of as many threads.
          run_in_arena(threads, [&] { parallel_for(0, 3, [&](int) { ++turns; }); });
          --inside;
        });
      });
      if (turns != 24) ++wrong;
    }
  };
  std::vector<std::jthread> callers;
  for (int i = 0; i < 40; ++i) callers.emplace_back(call, 1 + i % 4);
  callers.clear();
  EXPECT_EQ(wrong, 0);
}

TEST(Arena, IsUsedAgainAfterWhatIsThrown) {
  for (int i = 0; i < 100; ++i) {
    std::atomic<int> turns = 0;
    EXPECT_THROW(run_in_arena(2, [&] {
                   parallel_for(0, 100, [&](int at) {
                     if (at == 50) throw std::runtime_error("failed");
                   });
                 }), std::runtime_error);
    run_in_arena(2, [&] { parallel_for(0, 100, [&](int) { ++turns; }); });
    ASSERT_EQ(turns, 100);
  }
}

TEST(Arena, KeepsAThreadThatWaitsFromOtherTurns) {
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 4);
  std::atomic<int> entered_twice = 0;
  run_in_arena(4, [&] {
    parallel_for(0, 1000, [&](int) {
      thread_local bool is_within = false;
      if (is_within) ++entered_twice;
      is_within = true;
      run_isolated([] {
        parallel_for(0, 4, [](int) { std::this_thread::sleep_for(std::chrono::microseconds(50)); });
      });
      is_within = false;
    });
  });
  EXPECT_EQ(entered_twice, 0);
}

}  // namespace
}  // namespace octavo
