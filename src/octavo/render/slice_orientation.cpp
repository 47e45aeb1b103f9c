#include "octavo/render/slice_orientation.h"

#include <cmath>
#include <utility>

namespace octavo {

namespace {

/// Where an index axis points: a world axis (0 x, 1 y, 2 z of LPS) and its sign.
struct WorldAxis {
  int axis = 0;
  bool is_negative = false;
};

double component(const Geometry& geometry, int world_axis, int index_axis) {
  return geometry.direction[static_cast<std::size_t>(world_axis * 3 + index_axis)];
}

/// The assignment of index axes to world axes with the largest sum of components.
std::array<WorldAxis, 3> nearest_world_axes(const Geometry& geometry) {
  constexpr std::array<std::array<int, 3>, 6> kOrders = {
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::array<int, 3> best = kOrders[0];
  double best_sum = -1;
  for (const auto& order : kOrders) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      sum += std::abs(component(geometry, order[static_cast<std::size_t>(i)], i));
    }
    if (sum > best_sum) {
      best_sum = sum;
      best = order;
    }
  }
  std::array<WorldAxis, 3> axes;
  for (int i = 0; i < 3; ++i) {
    const int world = best[static_cast<std::size_t>(i)];
    axes[static_cast<std::size_t>(i)] = {world, component(geometry, world, i) < 0};
  }
  return axes;
}

}  // namespace

SliceOrientation slice_orientation(const Geometry& geometry, int axis) {
  const auto axes = nearest_world_axes(geometry);
  const auto world = [&](int index_axis) { return axes[static_cast<std::size_t>(index_axis)]; };
  SliceOrientation result;
  result.across = axis == 0 ? 1 : 0;
  result.down = axis == 2 ? 1 : 2;
  if (world(result.across).axis > world(result.down).axis) std::swap(result.across, result.down);

  const WorldAxis across = world(result.across);
  result.flips_across = across.is_negative;

  // y runs downwards on the screen as it does in LPS; z runs upwards.
  const WorldAxis down = world(result.down);
  const bool is_upright = down.axis == 2;
  result.flips_down = down.is_negative != is_upright;
  return result;
}

}  // namespace octavo
