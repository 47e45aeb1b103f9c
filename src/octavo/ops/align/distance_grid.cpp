#include "octavo/ops/align/distance_grid.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/vectors.h"

namespace octavo {

DistanceGrid::DistanceGrid(const std::vector<float>& mm, const Size3& size,
                           const Geometry& geometry, std::int64_t step)
    : step_(static_cast<double>(step)), geometry_(geometry) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    size_[axis] = (size[axis] - 1) / step + 1;
    last_[a] = static_cast<double>(size_[axis] - 1);
    apart_mm_[a] = step_ * geometry_.spacing_mm[a];
  }
  half_diagonal_mm_ = 0.5 * std::sqrt(dot(apart_mm_, apart_mm_));
  samples_.reserve(static_cast<std::size_t>(size_.voxel_count()));
  for (std::int64_t z = 0; z < size_.z; ++z) {
    for (std::int64_t y = 0; y < size_.y; ++y) {
      for (std::int64_t x = 0; x < size_.x; ++x) {
        const std::int64_t row = (z * step * size.y + y * step) * size.x;
        samples_.push_back(mm[static_cast<std::size_t>(row + x * step)]);
      }
    }
  }
  // Columns of the inverse, by what it makes of unit steps.
  const Point3 origin = geometry_.to_index(geometry_.origin_mm);
  for (std::size_t column = 0; column < 3; ++column) {
    Point3 world = geometry_.origin_mm;
    world[column] += 1;
    const Point3 moved = difference(geometry_.to_index(world), origin);
    for (std::size_t row = 0; row < 3; ++row) to_index_[3 * row + column] = moved[row] / step_;
  }
}

double DistanceGrid::sample_mm() const {
  return step_ * *std::min_element(geometry_.spacing_mm.begin(), geometry_.spacing_mm.end());
}

Point3 DistanceGrid::to_samples(const Point3& world) const {
  const Point3 from_origin = difference(world, geometry_.origin_mm);
  Point3 samples{};
  for (std::size_t a = 0; a < 3; ++a) {
    samples[a] = to_index_[3 * a] * from_origin[0] + to_index_[3 * a + 1] * from_origin[1] +
                 to_index_[3 * a + 2] * from_origin[2];
  }
  return samples;
}

double DistanceGrid::mm_at(const Point3& samples) const {
  const std::array<std::int64_t, 3> strides = {1, size_.x, size_.x * size_.y};
  std::array<std::int64_t, 3> next{};
  Point3 part{};
  std::int64_t low = 0;
  double beside2 = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double inside = std::clamp(samples[a], 0.0, last_[a]);
    const double beside = (samples[a] - inside) * apart_mm_[a];
    beside2 += beside * beside;
    const auto floor = static_cast<std::int64_t>(std::min(inside, std::max(0.0, last_[a] - 1)));
    part[a] = inside - static_cast<double>(floor);
    low += floor * strides[a];
    next[a] = last_[a] > 0 ? strides[a] : 0;
  }
  const float* const base = samples_.data() + low;
  const auto along_x = [&](std::int64_t row) {
    const double first = base[row];
    return first + part[0] * (base[row + next[0]] - first);
  };
  const auto in_plane = [&](std::int64_t plane) {
    const double first = along_x(plane);
    return first + part[1] * (along_x(plane + next[1]) - first);
  };
  const double first = in_plane(0);
  const double mm = first + part[2] * (in_plane(next[2]) - first);
  return beside2 > 0 ? mm + std::sqrt(beside2) : mm;
}

double DistanceGrid::mm_at_least(const Point3& samples) const {
  std::array<std::int64_t, 3> nearest{};
  double beside2 = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double inside = std::clamp(samples[a], 0.0, last_[a]);
    const double beside = (samples[a] - inside) * apart_mm_[a];
    beside2 += beside * beside;
    nearest[a] = static_cast<std::int64_t>(inside + 0.5);
  }
  const std::int64_t i = (nearest[2] * size_.y + nearest[1]) * size_.x + nearest[0];
  const double mm = samples_[static_cast<std::size_t>(i)];
  return mm - half_diagonal_mm_ + (beside2 > 0 ? std::sqrt(beside2) : 0);
}

GridDistance DistanceGrid::at(const Point3& world) const {
  const Point3 from_origin = difference(world, geometry_.origin_mm);
  std::array<std::int64_t, 3> low{};
  std::array<std::int64_t, 3> next{};  // how far the next sample along an axis is in memory
  Point3 part{};
  Point3 beside_mm{};  // from the nearest place in the volume, along the axes of the grid
  const std::array<std::int64_t, 3> strides = {1, size_.x, size_.x * size_.y};
  for (std::size_t a = 0; a < 3; ++a) {
    const Point3 row = {to_index_[3 * a], to_index_[3 * a + 1], to_index_[3 * a + 2]};
    const double index = dot(row, from_origin);
    const auto last = static_cast<double>(size_[static_cast<int>(a)] - 1);
    const double inside = std::clamp(index, 0.0, last);
    beside_mm[a] = (index - inside) * step_ * geometry_.spacing_mm[a];
    const double floor = std::min(std::floor(inside), std::max(0.0, last - 1));
    low[a] = static_cast<std::int64_t>(floor);
    part[a] = inside - floor;
    next[a] = last > 0 ? strides[a] : 0;
  }
  const float* const base = samples_.data() + low[0] + low[1] * strides[1] + low[2] * strides[2];
  const auto sample = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<double>(base[x * next[0] + y * next[1] + z * next[2]]);
  };
  // Along x, then y, then z.
  double along[2][2];
  double rise[2][2];
  for (std::int64_t z = 0; z < 2; ++z) {
    for (std::int64_t y = 0; y < 2; ++y) {
      const double first = sample(0, y, z);
      rise[z][y] = sample(1, y, z) - first;
      along[z][y] = first + part[0] * rise[z][y];
    }
  }
  double plane[2];
  double plane_x[2];
  double plane_y[2];
  for (int z = 0; z < 2; ++z) {
    plane_y[z] = along[z][1] - along[z][0];
    plane[z] = along[z][0] + part[1] * plane_y[z];
    plane_x[z] = rise[z][0] + part[1] * (rise[z][1] - rise[z][0]);
  }
  Point3 slope = {plane_x[0] + part[2] * (plane_x[1] - plane_x[0]),
                  plane_y[0] + part[2] * (plane_y[1] - plane_y[0]), plane[1] - plane[0]};
  GridDistance result;
  result.mm = plane[0] + part[2] * (plane[1] - plane[0]);

  // Beside the volume the way to it is added.
  const double beside = std::sqrt(dot(beside_mm, beside_mm));
  if (beside > 0) {
    result.mm += beside;
    for (std::size_t a = 0; a < 3; ++a) {
      const Point3 unit_row = {to_index_[3 * a], to_index_[3 * a + 1], to_index_[3 * a + 2]};
      if (beside_mm[a] == 0) continue;
      const double per_sample = step_ * geometry_.spacing_mm[a];
      slope[a] = 0;
      result.slope = sum(result.slope, scaled(unit_row, per_sample * beside_mm[a] / beside));
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const Point3 row = {to_index_[3 * a], to_index_[3 * a + 1], to_index_[3 * a + 2]};
    result.slope = sum(result.slope, scaled(row, slope[a]));
  }
  return result;
}

}  // namespace octavo
