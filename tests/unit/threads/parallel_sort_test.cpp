#include "octavo/threads/parallel_sort.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <random>

namespace octavo {
namespace {

std::vector<std::uint32_t> numbers_below(std::uint32_t limit, std::size_t count) {
  std::mt19937 random(7);
  std::vector<std::uint32_t> numbers(count);
  for (std::uint32_t& number : numbers) number = static_cast<std::uint32_t>(random()) % limit;
  return numbers;
}

TEST(ParallelSort, SortsAsOneThreadDoes) {
  for (const int threads : {1, 2, 3, 8}) {
    for (const std::size_t count : {0u, 1u, 2u, 4096u, 8191u, 8192u, 50001u}) {
      for (const std::uint32_t limit : {5u, 1u << 31}) {
        std::vector<std::uint32_t> numbers = numbers_below(limit, count);
        std::vector<std::uint32_t> expected = numbers;
        std::sort(expected.begin(), expected.end());
        run_in_arena(threads, [&] { parallel_sort(numbers); });
        EXPECT_EQ(numbers, expected) << threads << " threads, " << count << " numbers";
      }
    }
  }
}

TEST(ParallelSort, TakesAnOrderOfTheCaller) {
  std::vector<std::uint32_t> numbers = numbers_below(1000, 30000);
  run_in_arena(4, [&] {
    parallel_sort(numbers, [](std::uint32_t a, std::uint32_t b) { return a > b; });
  });
  EXPECT_TRUE(std::is_sorted(numbers.rbegin(), numbers.rend()));
}

}  // namespace
}  // namespace octavo
