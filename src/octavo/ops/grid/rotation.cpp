#include "octavo/ops/grid/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace octavo {

namespace {

struct CosSin {
  double cos = 1;
  double sin = 0;
};

CosSin cos_sin(double degrees) {
  const double turn = std::fmod(degrees, 360);
  const double quarters = turn / 90;
  if (quarters == std::floor(quarters)) {
    constexpr std::array<CosSin, 4> kQuarters = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
    return kQuarters[static_cast<std::size_t>(static_cast<int>(quarters) + 4) % 4];
  }
  const double angle = turn * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle)};
}

Point3 direction_of(const Point3& axis) {
  // Scaled first: squares of large numbers are infinite, those of small ones 0.
  const double largest = std::max({std::abs(axis[0]), std::abs(axis[1]), std::abs(axis[2])});
  Point3 result{axis[0] / largest, axis[1] / largest, axis[2] / largest};
  const double length = std::hypot(result[0], result[1], result[2]);
  for (double& part : result) part /= length;
  return result;
}

/// The quarter turns and mirrors that are nearest to a rotation, as far as axes change places.
std::array<std::size_t, 3> nearest_axes(const Rotation& rotation) {
  constexpr std::array<std::array<std::size_t, 3>, 6> kOrders = {
      {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}}};
  constexpr double kTie = 1e-9;
  std::array<std::size_t, 3> nearest = kOrders[0];
  double most = 0;
  for (const auto& from : kOrders) {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) sum += std::abs(rotation[3 * a + from[a]]);
    if (sum <= most + kTie) continue;
    most = sum;
    nearest = from;
  }
  return nearest;
}

/// Voxels that cover a length.
std::int64_t covering(double voxels) {
  constexpr double kSlack = 1e-6;
  constexpr double kMost = 9e15;
  return static_cast<std::int64_t>(std::clamp(std::ceil(voxels - kSlack), 1.0, kMost));
}

Point3 middle_of(const Size3& size) {
  return {static_cast<double>(size.x - 1) / 2, static_cast<double>(size.y - 1) / 2,
          static_cast<double>(size.z - 1) / 2};
}

/// Moves a geometry so that the center of `size` lies at `center_mm`.
void move_center(Geometry& geometry, const Size3& size, const Point3& center_mm) {
  geometry.origin_mm = {0, 0, 0};
  const Point3 center = geometry.to_world(middle_of(size));
  for (std::size_t row = 0; row < 3; ++row) geometry.origin_mm[row] = center_mm[row] - center[row];
}

}  // namespace

Rotation rotation_about(const Point3& axis, double degrees) {
  const auto [x, y, z] = direction_of(axis);
  const auto [c, s] = cos_sin(degrees);
  // Rodrigues: c I + s [k] + (1 - c) k k^T. On the diagonal c (1 - k k) + k k, which is exactly 1
  // along an axis of the grid.
  const double d = 1 - c;
  const auto along = [c = c](double k) { return c * (1 - k * k) + k * k; };
  return {along(x),          d * x * y - s * z, d * x * z + s * y,
          d * x * y + s * z, along(y),          d * y * z - s * x,
          d * x * z - s * y, d * y * z + s * x, along(z)};
}

Rotation rotation_of(const AxisTurn& turn) {
  Rotation rotation{};
  for (std::size_t a = 0; a < 3; ++a) {
    rotation[3 * a + static_cast<std::size_t>(turn.from[a])] = turn.is_reversed[a] ? -1 : 1;
  }
  return rotation;
}

Rotation chained(const Rotation& first, const Rotation& second) {
  return chained(Affine{first, {0, 0, 0}}, Affine{second, {0, 0, 0}}).linear;
}

std::optional<AxisTurn> as_turn(const Rotation& rotation) {
  constexpr double kRounding = 1e-12;
  AxisTurn turn;
  for (std::size_t a = 0; a < 3; ++a) {
    int found = 0;
    for (std::size_t f = 0; f < 3; ++f) {
      const double part = rotation[3 * a + f];
      if (std::abs(part) <= kRounding) continue;
      if (std::abs(std::abs(part) - 1) > kRounding) return std::nullopt;
      turn.from[a] = static_cast<int>(f);
      turn.is_reversed[a] = part < 0;
      ++found;
    }
    if (found != 1) return std::nullopt;
  }
  return turn;
}

TurnedGrid turned_grid(const Geometry& geometry, const Size3& size, const Rotation& rotation,
                       bool is_in_place) {
  if (const std::optional<AxisTurn> turn = as_turn(rotation)) {
    return {turned(size, *turn),
            is_in_place ? turned_object(geometry, size, *turn) : turned(geometry, size, *turn),
            to_source(*turn, size)};
  }
  TurnedGrid grid;
  grid.geometry = geometry;

  // Spacing, size and axes of the new grid.
  const std::array<std::size_t, 3> nearest = nearest_axes(rotation);
  for (std::size_t a = 0; a < 3; ++a) {
    const double spacing = geometry.spacing_mm[nearest[a]];
    double length = 0;
    for (std::size_t f = 0; f < 3; ++f) {
      length += std::abs(rotation[3 * a + f]) * geometry.spacing_mm[f] *
                static_cast<double>(size[static_cast<int>(f)]);
    }
    grid.geometry.spacing_mm[a] = spacing;
    grid.size[static_cast<int>(a)] = covering(length / spacing);
  }
  if (!is_in_place) {
    Rotation back;
    for (std::size_t i = 0; i < 9; ++i) back[i] = rotation[3 * (i % 3) + i / 3];
    grid.geometry.direction = chained(back, geometry.direction);
  }
  move_center(grid.geometry, grid.size, geometry.to_world(middle_of(size)));

  // From a voxel to its place from the center, turned back, to a voxel of the source.
  const Point3 center = middle_of(grid.size);
  grid.to_source.offset = middle_of(size);
  for (std::size_t f = 0; f < 3; ++f) {
    for (std::size_t a = 0; a < 3; ++a) {
      const double step =
          rotation[3 * a + f] * grid.geometry.spacing_mm[a] / geometry.spacing_mm[f];
      grid.to_source.linear[3 * f + a] = step;
      grid.to_source.offset[f] -= step * center[a];
    }
  }
  return grid;
}

}  // namespace octavo
