#include "octavo/threads/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <thread>
#include <vector>

#include "octavo/threads/arena.h"

namespace octavo {
namespace {

TEST(ParallelFor, CallsEachNumberOnce) {
  for (const int threads : {1, 3}) {
    for (const std::size_t count : {0u, 1u, 7u, 1000u}) {
      std::vector<std::atomic<int>> calls(count);
      run_in_arena(threads, [&] {
        parallel_for(std::size_t{0}, count, [&](std::size_t i) { ++calls[i]; });
      });
      for (const std::atomic<int>& called : calls) EXPECT_EQ(called, 1);
    }
  }
}

TEST(ParallelFor, BeginsWhereItIsToldTo) {
  std::atomic<int> sum = 0;
  parallel_for(-3, 6, [&](int i) { sum += i; });
  EXPECT_EQ(sum, 9);
  parallel_for(6, -3, [&](int) { sum = 0; });
  EXPECT_EQ(sum, 9);
}

TEST(ParallelFor, CutsNoPartSmallerThanHalfOfWhatIsAsked) {
  std::atomic<std::int64_t> covered = 0;
  parallel_parts(std::int64_t{5}, 1005, 100, [&](std::int64_t begin, std::int64_t end) {
    EXPECT_GE(begin, 5);
    EXPECT_LE(end, 1005);
    EXPECT_GE(end - begin, 50);
    covered += end - begin;
  });
  EXPECT_EQ(covered, 1000);
}

TEST(ParallelFor, JoinsWhatPartsGive) {
  const auto add = [](std::int64_t begin, std::int64_t end, std::int64_t sum) {
    for (std::int64_t i = begin; i < end; ++i) sum += i;
    return sum;
  };
  const auto join = [](std::int64_t a, std::int64_t b) { return a + b; };
  EXPECT_EQ(parallel_reduce(std::int64_t{0}, 10001, 16, std::int64_t{0}, add, join), 50005000);
  EXPECT_EQ(parallel_reduce(std::int64_t{4}, 4, 1, std::int64_t{0}, add, join), 0);
}

TEST(ParallelFor, HandsOnWhatATurnThrows) {
  EXPECT_THROW(parallel_for(0, 100, [](int i) { if (i == 40) throw std::runtime_error("40"); }),
               std::runtime_error);
}

TEST(ParallelFor, RunsEveryTurnOfALoopThatStandsInAFailedOne) {
  using std::chrono::milliseconds;
  std::atomic<bool> has_begun = false;
  std::atomic<bool> has_failed = false;
  std::atomic<int> turns = 0;
  const auto count_turn = [&](std::int64_t begin, std::int64_t end) {
    EXPECT_EQ(end - begin, 1);
    ++turns;
  };
  const auto fail = [&] {
    // A machine with much to do may have no other thread.
    for (int i = 0; i < 2000 && !has_begun; ++i) std::this_thread::sleep_for(milliseconds(1));
    has_failed = true;
    throw std::runtime_error("failed");
  };
  const auto fill = [&] {
    has_begun = true;
    while (!has_failed) std::this_thread::yield();
    // So that the failure is known to the loop around this one.
    std::this_thread::sleep_for(milliseconds(20));
    run_each(100, LoopWork(count_turn));
  };
  const auto take_turn = [&](int i) { i == 0 ? fail() : fill(); };
  EXPECT_THROW(run_in_arena(2, [&] { parallel_for(0, 2, take_turn); }), std::runtime_error);
  EXPECT_EQ(turns, has_begun ? 100 : 0);
}

}  // namespace
}  // namespace octavo
