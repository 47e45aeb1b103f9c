#include "octavo/ops/align/sight_lines.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/vectors.h"
#include "octavo/ops/measure/measure.h"

namespace octavo {

NearestSight nearest_sight(const DistanceGrid& grid, const SightLine& line, const SightReach& reach,
                           std::optional<double> expected_mm) {
  const Point3 along = unit(difference(line.to, line.from));
  const double nearest = dot(difference(reach.middle, line.from), along);
  const auto place_at = [&](double t) { return sum(line.from, scaled(along, t)); };
  const auto found_at = [&](double t) {
    return NearestSight{place_at(t), grid.at(place_at(t)), t};
  };
  const Point3 beside = difference(place_at(nearest), reach.middle);
  const double half2 = reach.radius_mm * reach.radius_mm - dot(beside, beside);
  if (half2 <= 0) return found_at(nearest);

  // In samples, so that a step is three additions.
  const Point3 middle = grid.to_samples(place_at(nearest));
  const Point3 per_mm = difference(grid.to_samples(place_at(nearest + 1)), middle);
  double best = nearest;
  double smallest = HUGE_VAL;
  const auto samples_at = [&](double t) { return sum(middle, scaled(per_mm, t - nearest)); };
  const auto look_at = [&](double t) {
    const double mm = grid.mm_at(samples_at(t));
    if (mm < smallest) {
      smallest = mm;
      best = t;
    }
    return mm;
  };
  look_at(nearest);
  const double half = std::sqrt(half2);
  if (expected_mm && std::abs(*expected_mm - nearest) < half) look_at(*expected_mm);

  // No distance grows or shrinks faster than the way that is gone.
  const double step = grid.sample_mm();
  for (double t = nearest - half; t <= nearest + half;) {
    const double mm = grid.mm_at_least(samples_at(t));
    t += std::max(step, (mm > smallest + step ? mm : look_at(t)) - smallest);
  }
  for (double part = step / 2; part > step / 16; part /= 2) {
    const double at = best;
    look_at(at - part);
    look_at(at + part);
  }
  return found_at(best);
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
