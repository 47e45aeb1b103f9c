#include "octavo/mesh/cost_heap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace octavo {
namespace {

TEST(CostHeap, GivesThingsByCostAndThenByNumber) {
  std::mt19937 random(5);
  for (const std::uint32_t count : {1u, 2u, 5u, 6u, 400u}) {
    CostHeap heap;
    std::vector<std::pair<float, std::uint32_t>> things;
    for (std::uint32_t i = 0; i < count; ++i) {
      const float cost = static_cast<float>(random() % 50) / 8 - 0.0f;
      things.emplace_back(cost, i);
      heap.push(cost, i);
    }
    std::sort(things.begin(), things.end());
    for (const auto& [cost, number] : things) {
      ASSERT_FALSE(heap.is_empty());
      EXPECT_EQ(heap.pop(), number) << cost;
    }
    EXPECT_TRUE(heap.is_empty());
  }
}

TEST(CostHeap, TakesMoreWhileThingsAreTakenOut) {
  CostHeap heap;
  heap.push(3, 0);
  heap.push(1, 1);
  EXPECT_EQ(heap.pop(), 1u);
  heap.push(2, 2);
  heap.push(0, 3);
  EXPECT_EQ(heap.pop(), 3u);
  EXPECT_EQ(heap.pop(), 2u);
  EXPECT_EQ(heap.pop(), 0u);
}

}  // namespace
}  // namespace octavo
