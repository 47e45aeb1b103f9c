#include "octavo/mesh/formats/point_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace octavo {

PointGrid PointGrid::around(const TriangleMesh& mesh, double margin_mm) {
  PointGrid grid;
  Point3 highest{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double lo = mesh.points.empty() ? 0 : mesh.points.front()[axis];
    double hi = lo;
    for (const MeshPoint& point : mesh.points) {
      lo = std::min<double>(lo, point[axis]);
      hi = std::max<double>(hi, point[axis]);
    }
    grid.origin_mm[axis] = lo - margin_mm;
    highest[axis] = hi + margin_mm;
  }
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    side = std::max(side, highest[axis] - grid.origin_mm[axis]);
  }
  grid.step_mm = side > 0 ? side / kMost : 1;
  return grid;
}

std::array<std::uint16_t, 3> PointGrid::numbers_of(const MeshPoint& point) const {
  std::array<std::uint16_t, 3> numbers;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double number = std::round((point[axis] - origin_mm[axis]) / step_mm);
    numbers[axis] = static_cast<std::uint16_t>(std::clamp<double>(number, 0, kMost));
  }
  return numbers;
}

MeshPoint PointGrid::place_of(const std::array<std::uint16_t, 3>& numbers) const {
  MeshPoint place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = static_cast<float>(origin_mm[axis] + step_mm * numbers[axis]);
  }
  return place;
}

double PointGrid::largest_move_mm() const {
  double farthest = 0;
  for (const double origin : origin_mm) {
    farthest = std::max({farthest, std::fabs(origin), std::fabs(origin + step_mm * kMost)});
  }
  const double rounding = farthest * std::numeric_limits<float>::epsilon();
  return std::sqrt(3.0) * (step_mm / 2 + rounding);
}

void PointGrid::snap(TriangleMesh& mesh) const {
  for (MeshPoint& point : mesh.points) point = place_of(numbers_of(point));
}

}  // namespace octavo
