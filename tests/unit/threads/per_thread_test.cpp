#include "octavo/threads/per_thread.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace octavo {
namespace {

TEST(PerThread, GivesEachThreadItsOwnValueAndKeepsIt) {
  std::atomic<int> made = 0;
  PerThread<std::vector<int>> values([&] { return std::vector<int>{++made}; });
  std::vector<std::thread> threads;
  for (int number = 0; number < 4; ++number) {
    threads.emplace_back([&values] {
      std::vector<int>& first = values.local();
      for (int i = 0; i < 100; ++i) values.local().push_back(i);
      EXPECT_EQ(&values.local(), &first);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(made, 4);
  EXPECT_EQ(values.size(), 4);
  for (const std::vector<int>& value : values) EXPECT_EQ(value.size(), 101);
}

TEST(PerThread, IsApartFromOthersOfTheSameThread) {
  PerThread<int> one;
  PerThread<int> other;
  one.local() = 1;
  EXPECT_EQ(other.local(), 0);
  EXPECT_EQ(one.local(), 1);
}

TEST(PerThread, HoldsWhatCannotBeMoved) {
  struct Fixed {
    explicit Fixed(int given) : number(given) {}
    Fixed(const Fixed&) = delete;
    int number;
  };
  PerThread<Fixed> values([] { return Fixed(5); });
  EXPECT_EQ(values.local().number, 5);
}

}  // namespace
}  // namespace octavo
