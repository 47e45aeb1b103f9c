#include "octavo/file/layer_order.h"

#include <algorithm>

namespace octavo {

namespace {

// Side of the smallest square of a power of two that holds the layer.
std::int64_t universe_side(const Size3& grid) {
  std::int64_t side = 1;
  while (side < grid.x || side < grid.y) side *= 2;
  return side;
}

// Positions of the grid in the square of `side` at (x, y).
std::int64_t count_in_square(const Size3& grid, std::int64_t x, std::int64_t y, std::int64_t side) {
  const std::int64_t width = std::min(grid.x, x + side) - x;
  const std::int64_t height = std::min(grid.y, y + side) - y;
  return width > 0 && height > 0 ? width * height : 0;
}

}  // namespace

std::int64_t place_in_layer(const Size3& brick_grid, const Index3& position) {
  std::int64_t place = 0;
  Index3 corner;
  for (std::int64_t side = universe_side(brick_grid) / 2; side > 0; side /= 2) {
    const bool is_far_x = position.x >= corner.x + side;
    const bool is_far_y = position.y >= corner.y + side;
    if (is_far_x) {
      place += count_in_square(brick_grid, corner.x, corner.y, side);
      place += count_in_square(brick_grid, corner.x, corner.y + side, side);
      corner.x += side;
    }
    if (is_far_y) {
      place += count_in_square(brick_grid, corner.x, corner.y, side);
      corner.y += side;
    }
  }
  return place;
}

Index3 position_in_layer(const Size3& brick_grid, std::int64_t place) {
  Index3 corner;
  for (std::int64_t side = universe_side(brick_grid) / 2; side > 0; side /= 2) {
    const std::int64_t near_x = count_in_square(brick_grid, corner.x, corner.y, side) +
                                count_in_square(brick_grid, corner.x, corner.y + side, side);
    if (place >= near_x) {
      place -= near_x;
      corner.x += side;
    }
    const std::int64_t near_y = count_in_square(brick_grid, corner.x, corner.y, side);
    if (place >= near_y) {
      place -= near_y;
      corner.y += side;
    }
  }
  return corner;
}

std::vector<Index3> layer_order(const Size3& brick_grid) {
  std::vector<Index3> order;
  const std::int64_t count = brick_grid.x * brick_grid.y;
  order.reserve(static_cast<std::size_t>(count));
  for (std::int64_t place = 0; place < count; ++place) {
    order.push_back(position_in_layer(brick_grid, place));
  }
  return order;
}

}  // namespace octavo
