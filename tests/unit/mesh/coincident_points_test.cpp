#include "octavo/mesh/coincident_points.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <random>
#include <vector>

namespace octavo {
namespace {

/// Points of a coarse grid, so that some repeat.
std::vector<MeshPoint> grid_points(std::size_t count, unsigned side) {
  std::mt19937 random(3);
  std::vector<MeshPoint> points(count);
  for (MeshPoint& point : points) {
    for (float& value : point) value = static_cast<float>(random() % side) * 0.5f - 7;
  }
  return points;
}

std::uint64_t counted_by_sorting(std::vector<MeshPoint> points) {
  std::sort(points.begin(), points.end());
  std::uint64_t count = 0;
  for (std::size_t i = 1; i < points.size(); ++i) count += points[i] == points[i - 1] ? 1u : 0u;
  return count;
}

TEST(CoincidentPoints, AreThoseThatSortingFinds) {
  for (const auto& [count, side] : {std::pair<std::size_t, unsigned>{0, 1}, {1, 1}, {50, 1},
                                    {5'000, 8}, {100'000, 40}, {300'000, 1000}}) {
    const auto points = grid_points(count, side);
    EXPECT_EQ(coincident_points(points), counted_by_sorting(points)) << count;
  }
}

TEST(CoincidentPoints, DoNotDependOnThreads) {
  const auto points = grid_points(200'000, 50);
  for (const int threads : {1, 2, 7}) {
    tbb::task_arena(threads).execute(
        [&] { EXPECT_EQ(coincident_points(points), counted_by_sorting(points)); });
  }
}

TEST(CoincidentPoints, TakeBothZerosForOnePlace) {
  const std::vector<MeshPoint> points = {{0, 1, -0.0f}, {-0.0f, 1, 0}, {0, -1, 0}};
  EXPECT_EQ(coincident_points(points), 1u);
}

}  // namespace
}  // namespace octavo
