#include <gtest/gtest.h>

#include "octavo/file/layer_order.h"
#include "octavo/octree/o_code.h"

namespace octavo {
namespace {

constexpr Size3 kGrids[] = {{1, 1, 1}, {3, 3, 2}, {1, 7, 1}, {8, 8, 1}, {5, 13, 4}, {33, 2, 1}};

TEST(LayerOrder, AscendsByOCode) {
  for (const Size3& grid : kGrids) {
    const std::vector<Index3> order = layer_order(grid);
    ASSERT_EQ(order.size(), static_cast<std::size_t>(grid.x * grid.y));
    for (std::size_t i = 1; i < order.size(); ++i) {
      EXPECT_LT(interleave(order[i - 1]), interleave(order[i]));
    }
  }
}

TEST(LayerOrder, HoldsOnlyPositionsOfTheGrid) {
  for (const Size3& grid : kGrids) {
    for (const Index3& position : layer_order(grid)) {
      EXPECT_TRUE(box_of(grid).contains(position));
      EXPECT_EQ(position.z, 0);
    }
  }
}

TEST(LayerOrder, PlaceIsTheInverseOfPosition) {
  for (const Size3& grid : kGrids) {
    for (std::int64_t place = 0; place < grid.x * grid.y; ++place) {
      EXPECT_EQ(place_in_layer(grid, position_in_layer(grid, place)), place);
    }
  }
}

TEST(LayerOrder, PlaceOfAHugeGridNeedsNoTable) {
  const Size3 grid{1 << 19, 1 << 19, 1};
  const Index3 position{123456, 654321 % (1 << 19), 0};
  EXPECT_EQ(position_in_layer(grid, place_in_layer(grid, position)), position);
}

}  // namespace
}  // namespace octavo
