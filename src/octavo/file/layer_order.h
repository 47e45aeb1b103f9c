// The order of the bricks of one layer: by o-code, which inside a layer is a Morton order of (x, y)
// with x ranking above y. A grid that is no power of two skips the positions outside it.
//
//     grid 3 x 3:   y ->       place of (x, y): the positions of all earlier quadrants
//               x   0 1 4      that lie in the grid, counted from the largest quadrant down
//               |   2 3 5
//               v   6 7 8
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/box.h"

namespace octavo {

/// How many bricks of the layer come before `position`; z is ignored.
/// Requires a position inside the grid. Complexity O(log of the larger axis)
std::int64_t place_in_layer(const Size3& brick_grid, const Index3& position);

/// The (x, y) position with that place, z = 0. Requires 0 <= place < grid.x * grid.y.
Index3 position_in_layer(const Size3& brick_grid, std::int64_t place);

/// The (x, y) positions of one brick layer in o-code order, z = 0.
std::vector<Index3> layer_order(const Size3& brick_grid);

}  // namespace octavo
