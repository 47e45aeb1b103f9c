#include "octavo/mesh/hexahedra/hex_nodes.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "hex_samples.h"
#include "octavo/core/error.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// Corners of cells, and those that lie on the border of a cell without being a corner of it.
struct DenseNodes {
  explicit DenseNodes(const std::vector<HexCell>& cells) {
    for (const HexCell& cell : cells) {
      for (const auto& step : kHexCorners) {
        GridPoint point = cell.corner;
        for (std::size_t axis = 0; axis < 3; ++axis) point[axis] += step[axis] * cell.side();
        all.insert(point);
      }
    }
    for (const HexCell& cell : cells) {
      for (const GridPoint& point : all) {
        int ends = 0;
        int between = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::uint32_t at = point[axis] - cell.corner[axis];  // wraps where it lies before
          if (at == 0 || at == cell.side()) ++ends;
          else if (at < cell.side()) ++between;
        }
        if (ends + between == 3 && ends != 3) hanging.insert(point);
      }
    }
  }

  std::set<GridPoint> all;
  std::set<GridPoint> hanging;
};

std::vector<HexCell> random_cells(std::mt19937& random) {
  const auto labels = testing::random_labels({16, 13, 18}, testing::kHexLabels, random);
  return testing::cells_of_tree(testing::tree_of(labels), HexMethod::octree);
}

TEST(HexNodes, AreTheCornersAndHangWhereTheyLieOnAnotherCell) {
  std::mt19937 random(3);
  for (int run = 0; run < 12; ++run) {
    const std::vector<HexCell> cells = random_cells(random);
    const HexNodes nodes(cells);
    const DenseNodes dense(cells);
    ASSERT_EQ(nodes.count(), dense.all.size());
    ASSERT_EQ(nodes.hanging_count(), dense.hanging.size());
    std::uint32_t next = 0;
    nodes.visit([&](const GridPoint& point, std::uint32_t number) {
      EXPECT_EQ(number, next++);
      EXPECT_EQ(nodes.number_at(point), number);
      EXPECT_TRUE(dense.all.contains(point));
      EXPECT_EQ(nodes.is_hanging(number), dense.hanging.contains(point));
    });
    EXPECT_EQ(next, nodes.count());
  }
}

TEST(HexNodes, MastersAreTheMeanAndNoneOfThemHangs) {
  std::mt19937 random(9);
  for (int run = 0; run < 30; ++run) {
    const HexNodes nodes(random_cells(random));
    std::map<std::uint32_t, GridPoint> places;
    nodes.visit([&](const GridPoint& point, std::uint32_t number) { places[number] = point; });
    std::uint32_t visited = 0;
    nodes.visit_hanging([&](const GridPoint& point, std::uint32_t number) {
      ++visited;
      EXPECT_TRUE(nodes.is_hanging(number));
      const HexMasters masters = nodes.masters_of(point);
      ASSERT_TRUE(masters.count == 2 || masters.count == 4);
      const auto count = static_cast<std::size_t>(masters.count);
      std::array<std::uint64_t, 3> sum{};
      for (std::size_t i = 0; i < count; ++i) {
        ASSERT_LT(masters.nodes[i], nodes.count());
        EXPECT_FALSE(nodes.is_hanging(masters.nodes[i]));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          sum[axis] += places.at(masters.nodes[i])[axis];
        }
      }
      for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(sum[axis], count * point[axis]);
    });
    EXPECT_EQ(visited, nodes.hanging_count());
  }
}

TEST(HexNodes, VoxelsShareTheirCornersAndNoneHangs) {
  testing::DenseLabels labels({7, 5, 3}, 1);
  const HexNodes nodes(
      testing::cells_of_tree(testing::tree_of(labels), HexMethod::uniform));
  EXPECT_EQ(nodes.count(), 8u * 6 * 4);
  EXPECT_EQ(nodes.hanging_count(), 0u);
  EXPECT_EQ(nodes.number_at({8, 0, 0}), HexNodes::kNone);
  EXPECT_EQ(nodes.number_at({100, 0, 0}), HexNodes::kNone);
}

TEST(HexNodes, AreTheSameWithAnyThreads) {
  std::mt19937 random(5);
  testing::DenseLabels labels({40, 44, 48}, 1);
  for (std::size_t i = 0; i < labels.voxels.size() / 2; ++i) {
    labels.voxels[i] = random() % 3 == 0 ? 0 : 1;
  }
  const std::vector<HexCell> cells =
      testing::cells_of_tree(testing::tree_of(labels), HexMethod::octree);
  ASSERT_GT(cells.size(), 3u * 4096);  // parts of cells that threads take
  using Points = std::vector<GridPoint>;
  const auto points_with = [&](int threads) {
    Points points;
    tbb::task_arena(threads).execute([&] {
      const HexNodes nodes(cells);
      nodes.visit([&](const GridPoint& point, std::uint32_t) { points.push_back(point); });
    });
    return points;
  };
  const Points one = points_with(1);
  for (const int threads : {2, 7}) EXPECT_EQ(points_with(threads), one);
}

TEST(HexNodes, EndWhenAskedTo) {
  const testing::DenseLabels labels({40, 40, 40}, 1);
  const LabelTree tree = testing::tree_of(labels);
  const std::vector<HexCell> cells = testing::cells_of_tree(tree, HexMethod::uniform);
  const testing::StoppingProgress stopping;
  EXPECT_THROW(HexNodes(cells, stopping), Error);
  EXPECT_THROW(hex_cells(tree, {HexMethod::octree, nullptr, false, &stopping},
                         [](std::uint64_t) {}),
               Error);
}

}  // namespace
}  // namespace octavo
