#include "octavo/ops/morphometry/ellipsoid_search.h"

#include <algorithm>
#include <cmath>

#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr std::size_t kPlacesAtOnce = 16;
constexpr float kFarAway = 1e18F;
constexpr double kLongestStep = 0.5;
constexpr double kShortestStep = 0.01;
constexpr int kFailuresAStep = 10;

double volume_of(const FreeEllipsoid& one) {
  return one.lengths[0] * one.lengths[1] * one.lengths[2];
}

/// Places are those that are seen from 0: all there are for an ellipsoid that holds 0.
bool holds_start(const FreeEllipsoid& one) {
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double part = dot(one.center, one.axes[i]) / one.lengths[i];
    squares += part * part;
  }
  return squares < 1;
}

/// Turned by a small vector, and made square again.
void turn_axes(std::array<Point3, 3>& axes, const Point3& by) {
  axes[0] = unit(sum(axes[0], cross(by, axes[0])));
  const Point3 second = sum(axes[1], cross(by, axes[1]));
  axes[1] = unit(difference(second, scaled(axes[0], dot(second, axes[0]))));
  axes[2] = cross(axes[0], axes[1]);
}

}  // namespace

EllipsoidSearch::EllipsoidSearch(double drift, double longest, std::uint64_t seed)
    : drift_(drift), longest_(longest), state_(seed * 0x9E3779B97F4A7C15U + 1) {}

void EllipsoidSearch::add(const Point3& place) {
  // Rows are filled up to whole blocks by places that are met last.
  const std::size_t count = places_[0].size();
  std::size_t free = count;
  while (free > 0 && places_[0][free - 1] == kFarAway) --free;
  if (free == count) {
    for (auto& row : places_) row.resize(count + kPlacesAtOnce, kFarAway);
  }
  for (std::size_t a = 0; a < 3; ++a) places_[a][free] = static_cast<float>(place[a]);
}

double EllipsoidSearch::size_of(const FreeEllipsoid& form) const {
  std::array<std::array<float, 3>, 3> to;
  std::array<float, 3> shift{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t a = 0; a < 3; ++a) {
      to[i][a] = static_cast<float>(form.axes[i][a] / form.lengths[i]);
    }
    shift[i] = static_cast<float>(dot(form.axes[i], form.center) / form.lengths[i]);
  }
  std::array<float, kPlacesAtOnce> nearest;
  nearest.fill(kFarAway);
  for (std::size_t begin = 0; begin < places_[0].size(); begin += kPlacesAtOnce) {
    const float* const x = places_[0].data() + begin;
    const float* const y = places_[1].data() + begin;
    const float* const z = places_[2].data() + begin;
    for (std::size_t k = 0; k < kPlacesAtOnce; ++k) {
      const float u = to[0][0] * x[k] + to[0][1] * y[k] + to[0][2] * z[k] - shift[0];
      const float v = to[1][0] * x[k] + to[1][1] * y[k] + to[1][2] * z[k] - shift[1];
      const float w = to[2][0] * x[k] + to[2][1] * y[k] + to[2][2] * z[k] - shift[2];
      const float squares = u * u + v * v + w * w;
      nearest[k] = squares < nearest[k] ? squares : nearest[k];
    }
  }
  const float squares = *std::min_element(nearest.begin(), nearest.end());
  const double longest = std::max({form.lengths[0], form.lengths[1], form.lengths[2]});
  return std::min(std::sqrt(static_cast<double>(squares)), longest_ / longest);
}

double EllipsoidSearch::random() {
  state_ = state_ * 6364136223846793005U + 1442695040888963407U;
  return 2 * static_cast<double>(state_ >> 11) / 9007199254740992.0 - 1;
}

Point3 EllipsoidSearch::random_place(double reach) {
  const double x = random();
  const double y = random();
  return {reach * x, reach * y, reach * random()};
}

void EllipsoidSearch::improve(FreeEllipsoid& ellipsoid, int tries) {
  ellipsoid.lengths = scaled(ellipsoid.lengths, size_of(ellipsoid));
  for (int i = 0; i < tries; ++i) {
    FreeEllipsoid next = ellipsoid;
    switch (i % 4) {
      case 0:
        next.center = sum(next.center, random_place(step_ * drift_));
        if (dot(next.center, next.center) > drift_ * drift_) continue;
        break;
      case 1: turn_axes(next.axes, random_place(step_)); break;
      case 2:
        for (double& length : next.lengths) length *= std::exp(step_ * random());
        break;
      default:
        next.lengths[static_cast<std::size_t>(i / 4 % 3)] *= 1 + step_ * std::abs(random());
        turn_axes(next.axes, random_place(0.3 * step_));
    }
    next.lengths = scaled(next.lengths, size_of(next));
    if (volume_of(next) > volume_of(ellipsoid) && holds_start(next)) {
      ellipsoid = next;
      failed_ = 0;
      step_ = std::min(kLongestStep, 1.15 * step_);
    } else if (++failed_ > kFailuresAStep) {
      failed_ = 0;
      step_ = std::max(kShortestStep, 0.7 * step_);
    }
  }
}

}  // namespace octavo
