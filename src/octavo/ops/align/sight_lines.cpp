#include "octavo/ops/align/sight_lines.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/vectors.h"
#include "octavo/ops/measure/measure.h"

namespace octavo {

NearestSight nearest_sight(const DistanceGrid& grid, const SightLine& line,
                           const SightReach& reach) {
  const Point3 along = unit(difference(line.to, line.from));
  const double nearest = dot(difference(reach.middle, line.from), along);
  const auto place_at = [&](double t) { return sum(line.from, scaled(along, t)); };
  const Point3 beside = difference(place_at(nearest), reach.middle);
  const double half2 = reach.radius_mm * reach.radius_mm - dot(beside, beside);
  NearestSight found{place_at(nearest), grid.at(place_at(nearest))};
  if (half2 <= 0) return found;

  // No distance grows or shrinks faster than the way that is gone.
  const double step = grid.sample_mm();
  const double end = nearest + std::sqrt(half2);
  double best = nearest;
  const auto look_at = [&](double t) {
    const Point3 place = place_at(t);
    const GridDistance distance = grid.at(place);
    if (distance.mm < found.distance.mm) {
      found = {place, distance};
      best = t;
    }
    return distance.mm;
  };
  for (double t = nearest - std::sqrt(half2); t <= end;) {
    const double mm = look_at(t);
    t += std::max(step, mm - found.distance.mm);
  }
  for (double part = step / 2; part > step / 16; part /= 2) {
    const double middle = best;
    look_at(middle - part);
    look_at(middle + part);
  }
  return found;
}

SightMiddle middle_of(std::span<const SightLine> lines) {
  // Normal equations: what of a way is across the lines.
  std::array<double, 9> across{};
  Point3 right{};
  for (const SightLine& line : lines) {
    const Point3 u = unit(difference(line.to, line.from));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double part = (i == j ? 1 : 0) - u[i] * u[j];
        across[3 * i + j] += part;
        right[i] += part * line.from[j];
      }
    }
  }
  RegionMeasure shape;
  shape.covariance = {across[0], across[4], across[8], across[1], across[2], across[5]};
  const auto axes = principal_axes(shape, Geometry{});
  SightMiddle result;
  const auto count = static_cast<double>(lines.size());
  double weakest = count;
  for (const Point3& axis : axes.axes) {
    Point3 turned{};
    for (std::size_t i = 0; i < 3; ++i) {
      turned[i] = across[3 * i] * axis[0] + across[3 * i + 1] * axis[1] +
                  across[3 * i + 2] * axis[2];
    }
    const double strength = dot(axis, turned);
    weakest = std::min(weakest, strength);
    if (strength > 1e-9 * count) {
      result.middle = sum(result.middle, scaled(axis, dot(axis, right) / strength));
    }
  }
  result.hold = weakest / count;
  for (const SightLine& line : lines) {
    const Point3 u = unit(difference(line.to, line.from));
    const Point3 way = cross(difference(result.middle, line.from), u);
    result.radius_mm += dot(way, way) / count;
  }
  result.radius_mm = std::sqrt(result.radius_mm);
  return result;
}

}  // namespace octavo
