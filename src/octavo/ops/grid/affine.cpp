#include "octavo/ops/grid/affine.h"

#include <algorithm>
#include <cmath>

namespace octavo {

Point3 Affine::operator()(const Point3& p) const {
  Point3 result = offset;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t i = 0; i < 3; ++i) result[row] += linear[3 * row + i] * p[i];
  }
  return result;
}

Affine chained(const Affine& first, const Affine& second) {
  Affine both;
  both.offset = second(first.offset);
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      double sum = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        sum += second.linear[3 * row + i] * first.linear[3 * i + column];
      }
      both.linear[3 * row + column] = sum;
    }
  }
  return both;
}

std::optional<Affine> inverse(const Affine& map) {
  const auto& m = map.linear;
  // Cofactors, transposed.
  Affine back;
  double largest = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const std::size_t r1 = (column + 1) % 3;
      const std::size_t r2 = (column + 2) % 3;
      const std::size_t c1 = (row + 1) % 3;
      const std::size_t c2 = (row + 2) % 3;
      back.linear[3 * row + column] = m[3 * r1 + c1] * m[3 * r2 + c2] -
                                      m[3 * r1 + c2] * m[3 * r2 + c1];
      largest = std::max(largest, std::abs(m[3 * row + column]));
    }
  }
  const double determinant =
      m[0] * back.linear[0] + m[1] * back.linear[3] + m[2] * back.linear[6];
  constexpr double kFlat = 1e-12;
  if (!(std::abs(determinant) > kFlat * largest * largest * largest)) return std::nullopt;
  for (double& part : back.linear) part /= determinant;
  back.offset = {0, 0, 0};
  const Point3 moved = back(map.offset);
  for (std::size_t i = 0; i < 3; ++i) back.offset[i] = 0 - moved[i];
  for (std::size_t i = 0; i < 9; ++i) {
    if (!std::isfinite(back.linear[i]) || !std::isfinite(back.offset[i % 3])) return std::nullopt;
  }
  return back;
}

Affine index_to_world(const Geometry& geometry) {
  Affine map;
  map.offset = geometry.origin_mm;
  for (std::size_t i = 0; i < 9; ++i) {
    map.linear[i] = geometry.direction[i] * geometry.spacing_mm[i % 3];
  }
  return map;
}

bool may_meet(const Affine& to_source, const Size3& grid, const Size3& source) {
  // Boxes around both, in the source.
  for (std::size_t row = 0; row < 3; ++row) {
    double lo = to_source.offset[row];
    double hi = lo;
    for (int axis = 0; axis < 3; ++axis) {
      const double reach = to_source.linear[3 * row + static_cast<std::size_t>(axis)] *
                           static_cast<double>(grid[axis] - 1);
      (reach < 0 ? lo : hi) += reach;
    }
    if (hi < -0.5 || lo > static_cast<double>(source[static_cast<int>(row)]) - 0.5) return false;
  }
  return true;
}

Affine to_source(const AxisTurn& turn, const Size3& size) {
  Affine map;
  map.linear = {};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto from = static_cast<std::size_t>(turn.from[a]);
    map.linear[3 * from + a] = turn.is_reversed[a] ? -1 : 1;
    map.offset[from] = turn.is_reversed[a] ? static_cast<double>(size[turn.from[a]] - 1) : 0;
  }
  return map;
}

}  // namespace octavo
