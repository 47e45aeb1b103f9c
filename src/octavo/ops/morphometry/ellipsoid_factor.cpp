#include "octavo/ops/morphometry/ellipsoid_factor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/octree/mask_accessor.h"
#include "octavo/ops/morphometry/ellipsoid_search.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::size_t kMostEllipsoids = 1000;
constexpr int kRays = 300;
constexpr int kRounds = 3;          // each looks where the ellipsoid of the one before is
constexpr double kRayArea = 4;      // of the ellipsoid, in squares of the smallest spacing
constexpr int kFewestRays = 100;    // of a round
constexpr int kMostRays = 4000;
constexpr int kTriesARound = 100;
constexpr double kLongestRay = 12;  // radii of the ball
constexpr double kDrift = 1.75;    // of the center, in voxels
constexpr double kRayStep = 0.25;  // of a ray, in voxels

/// A direction of `count` that are spread evenly over the sphere.
Point3 ray_at(int i, int count) {
  constexpr double kGolden = 2.399963229728653;  // the golden angle
  const double z = 1 - (2 * i + 1.0) / count;
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(kGolden * i), r * std::sin(kGolden * i), z};
}

struct GrownEllipsoid : FreeEllipsoid {

  double volume() const { return lengths[0] * lengths[1] * lengths[2]; }

  Point3 surface_at(const Point3& ray) const {
    Point3 at = center;
    for (std::size_t a = 0; a < 3; ++a) at = sum(at, scaled(axes[a], ray[a] * lengths[a]));
    return at;
  }

  double longest() const { return std::max({lengths[0], lengths[1], lengths[2]}); }

  double factor() const {
    std::array<double, 3> sorted = lengths;
    std::sort(sorted.begin(), sorted.end());
    return sorted[0] / sorted[1] - sorted[1] / sorted[2];
  }

  bool holds(const Point3& place) const {
    const Point3 p = difference(place, center);
    if (dot(p, p) > longest() * longest()) return false;
    double squares = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double part = dot(p, axes[i]) / lengths[i];
      squares += part * part;
    }
    return squares <= 1;
  }
};

class EllipsoidGrower {
 public:
  EllipsoidGrower(const ThicknessClass& asked, const MaskAccessor& mask, const Point3& spacing)
      : asked_(asked), mask_(mask), spacing_(spacing) {
    step_ = kRayStep * std::min({spacing[0], spacing[1], spacing[2]});
  }

  GrownEllipsoid grow(const FittingBall& ball, std::uint64_t seed) const {
    Point3 center{};
    for (std::size_t a = 0; a < 3; ++a) {
      center[a] = static_cast<double>(ball.center[a]) * spacing_[a];
    }
    const double radius = static_cast<double>(ball.radius_mm);
    // No center of the other class is nearer than the ball reaches; their voxels begin half a
    // diagonal before.
    const double within =
        std::min(static_cast<double>(ball.reach_mm) - 0.5 * std::sqrt(dot(spacing_, spacing_)),
                 to_border(center));
    const double most = kLongestRay * radius + 4 * step_;
    EllipsoidSearch search(kDrift * std::min({spacing_[0], spacing_[1], spacing_[2]}), most, seed);
    std::vector<Point3> surface;
    double shortest = HUGE_VAL;
    Point3 first{};
    for (int i = 0; i < kRays; ++i) {
      const Point3 ray = ray_at(i, kRays);
      const double length = length_along(center, ray, within, most);
      surface.push_back(scaled(ray, length));
      search.add(surface.back());
      if (length < shortest) {
        shortest = length;
        first = ray;
      }
    }
    if (!(shortest > 0)) return {{center, {}, {}}};
    first = middle_of_near(surface, first, shortest);
    GrownEllipsoid grown = fitted(surface, first, shortest, most);
    search.improve(grown, 0);
    // What lies between the rays, where the ellipsoid is now, holds it as well.
    for (int round = 0; round < kRounds; ++round) {
      const int rays = rays_around(grown);
      for (int i = 0; i < rays; ++i) {
        const Point3 to = grown.surface_at(ray_at(i, rays));
        const double far = std::sqrt(dot(to, to));
        const Point3 ray = scaled(to, 1 / far);
        const double length = length_along(center, ray, within, std::min(most, 1.5 * far));
        if (length < 1.5 * far) search.add(scaled(ray, length));
      }
      search.improve(grown, kTriesARound);
    }
    grown.center = sum(grown.center, center);
    return grown;
  }

 private:
  /// So many that nothing slips through between them.
  int rays_around(const GrownEllipsoid& grown) const {
    const auto& [a, b, c] = grown.lengths;
    const double squares = (a * a * b * b + b * b * c * c + c * c * a * a) / 3;
    const double voxel = step_ / kRayStep;
    const double area = 4 * std::numbers::pi * std::sqrt(squares) / (voxel * voxel);
    return static_cast<int>(std::clamp<double>(area / kRayArea, kFewestRays, kMostRays));
  }

  /// To the border of the volume, beyond which balls may reach.
  double to_border(const Point3& center) const {
    double nearest = HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double end = static_cast<double>(asked_.mask.size()[axis]) * spacing_[a];
      nearest = std::min({nearest, center[a], end - center[a]});
    }
    return nearest;
  }

  /// From voxel to voxel, up to one that is not of the class.
  double length_along(const Point3& center, const Point3& ray, double within, double most) const {
    double t = std::max(within, 0.0);
    Index3 voxel;
    Point3 next{};  // where the ray leaves the voxel along each axis
    Point3 step{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const double place = (center[a] + t * ray[a]) / spacing_[a];
      voxel[axis] = static_cast<std::int64_t>(std::floor(place));
      const auto face = static_cast<double>(voxel[axis] + (ray[a] > 0 ? 1 : 0));
      step[a] = spacing_[a] / std::abs(ray[a]);
      next[a] = ray[a] == 0 ? HUGE_VAL : (face * spacing_[a] - center[a]) / ray[a];
    }
    const Box all = box_of(asked_.mask.size());
    while (t < most) {
      if (!all.contains(voxel) || mask_.contains(voxel) == asked_.is_background) return t;
      const int first = next[0] < next[1] ? 0 : 1;
      const int axis = next[static_cast<std::size_t>(first)] < next[2] ? first : 2;
      const auto a = static_cast<std::size_t>(axis);
      t = next[a];
      next[a] += step[a];
      voxel[axis] += ray[a] > 0 ? 1 : -1;
    }
    return most;
  }

  /// The middle of all rays around `first` that are as short, or run the other way: few rays hit a
  /// plate squarely.
  Point3 middle_of_near(const std::vector<Point3>& surface, const Point3& first,
                        double shortest) const {
    constexpr double kAround = 0.7;  // cosine
    Point3 middle{};
    for (const Point3& p : surface) {
      const double length = std::sqrt(dot(p, p));
      const double cosine = dot(p, first) / length;
      if (length > shortest + 1.5 * step_ || std::abs(cosine) < kAround) continue;
      middle = sum(middle, scaled(p, (cosine > 0 ? 1 : -1) / length));
    }
    return unit(middle);
  }

  /// The axes across the first one, as long as no place of the surface lies within. Places are
  /// known to a voxel: those that lie within by no more touch it and do not hold what comes across.
  GrownEllipsoid fitted(const std::vector<Point3>& surface, const Point3& first, double shortest,
                        double most) const {
    const auto square = [](double x) { return x * x; };
    const double touching = square(std::max(0.5, 1 - step_ / (kRayStep * shortest)));
    double second_length = most;
    Point3 second{};
    for (const Point3& p : surface) {
      const double along = dot(p, first);
      const double used = square(along / shortest);
      if (used >= touching) continue;
      const Point3 across = difference(p, scaled(first, along));
      const double length = std::sqrt(dot(across, across) / (1 - used));
      if (length < second_length) {
        second_length = length;
        second = across;
      }
    }
    if (!(dot(second, second) > 0)) {
      second = cross(first, std::abs(first[2]) < 0.9 ? Point3{0, 0, 1} : Point3{1, 0, 0});
    }
    second = unit(second);
    const Point3 third = cross(first, second);
    double third_length = most;
    for (const Point3& p : surface) {
      const double used = square(dot(p, first) / shortest) + square(dot(p, second) / second_length);
      if (used >= touching) continue;
      third_length = std::min(third_length, std::abs(dot(p, third)) / std::sqrt(1 - used));
    }
    return {{{}, {first, second, third}, {shortest, second_length, third_length}}};
  }

  const ThicknessClass& asked_;
  const MaskAccessor& mask_;
  Point3 spacing_;
  double step_;
};

/// What a center stands for.
struct HeldCenter {
  double volume = 0;
  double factor = 0;
};

/// The factor of the first ellipsoid that holds a center. Where several overlap each has a center,
/// so that one stands for less.
HeldCenter held_center(const std::vector<GrownEllipsoid>& largest_first,
                       const GrownEllipsoid& own) {
  const GrownEllipsoid* first = nullptr;
  int holders = 0;
  for (const GrownEllipsoid& one : largest_first) {
    if (!one.holds(own.center)) continue;
    if (first == nullptr) first = &one;
    ++holders;
  }
  // None where the center lies on a face of the surface: its own has no extent.
  if (first == nullptr) return {};
  return {own.volume() / holders, first->factor()};
}

}  // namespace

std::int64_t ellipsoid_count(const std::vector<FittingBall>& balls) {
  return static_cast<std::int64_t>(std::min(balls.size(), kMostEllipsoids));
}

std::optional<EllipsoidFactors> ellipsoid_factors(const ThicknessClass& asked,
                                                  const Point3& spacing_mm,
                                                  const std::vector<FittingBall>& balls,
                                                  Progress& progress) {
  if (balls.empty()) return std::nullopt;
  const MaskAccessor mask(asked.mask);
  const EllipsoidGrower grower(asked, mask, spacing_mm);
  std::vector<GrownEllipsoid> grown(static_cast<std::size_t>(ellipsoid_count(balls)));
  parallel_for(std::size_t{0}, grown.size(), [&](std::size_t i) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
    grown[i] = grower.grow(balls[i * balls.size() / grown.size()], i);
    progress.advance(1);
  });
  // The largest first: each center belongs to the first ellipsoid that holds it, its own at last.
  std::stable_sort(grown.begin(), grown.end(),
                   [](const GrownEllipsoid& one, const GrownEllipsoid& other) {
                     return one.volume() > other.volume();
                   });
  std::vector<HeldCenter> centers(grown.size());
  parallel_for(std::size_t{0}, grown.size(),
                    [&](std::size_t i) { centers[i] = held_center(grown, grown[i]); });
  EllipsoidFactors factors;
  factors.ellipsoids = grown.size();
  double volume = 0;
  double squares = 0;
  for (const HeldCenter& center : centers) {
    volume += center.volume;
    factors.mean += center.volume * center.factor;
    squares += center.volume * center.factor * center.factor;
    const double step = std::clamp((center.factor + 1) * 10, 0.0, 19.0);
    factors.shares[static_cast<std::size_t>(step)] += center.volume;
  }
  if (!(volume > 0)) return std::nullopt;
  factors.mean /= volume;
  factors.deviation = std::sqrt(std::max(0.0, squares / volume - factors.mean * factors.mean));
  for (double& share : factors.shares) share /= volume;
  return factors;
}

}  // namespace octavo
