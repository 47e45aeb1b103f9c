// One ray in samples of a grid: where it runs, enters and leaves, and where it finds its values.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "octavo/render/rays/ray_job.h"

namespace octavo {

using RayPlace = std::array<float, 3>;
using RayCell = std::array<std::int32_t, 3>;

/// Where k runs while a ray is inside.
struct RaySpan {
  float enter = 0;
  float leave = 0;
  std::size_t axis = 0;  // of the face through which it enters
};

struct RayLine {
  float start = 0;  // where it begins, in steps
  RayPlace origin{};
  RayPlace step{};
  RayPlace inverse{};  // 1 / step
};

inline RayLine ray_at(const RayFrame& f, float u, float v) {
  RayLine ray;
  float scale = 1;
  if (f.eye_pixels > 0) {
    scale = f.step_pixels / std::sqrt(u * u + v * v + f.eye_pixels * f.eye_pixels);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.origin[axis] =
        f.origin[axis] + u * f.origin_across[axis] + v * f.origin_down[axis];
    ray.step[axis] =
        (f.direction[axis] + u * f.direction_across[axis] + v * f.direction_down[axis]) * scale;
    // A ray along a plane of the grid: nothing is divided by 0.
    if (std::abs(ray.step[axis]) < kSmallestStep) ray.step[axis] = kSmallestStep;
  }
  return ray;
}

/// The same ray with its samples on the planes of the grid that it crosses most squarely.
/// What it begins at lies behind the first of them where there is an eye, which may be inside.
inline RayLine on_planes(RayLine ray, bool has_eye) {
  std::size_t main = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    if (std::abs(ray.step[axis]) > std::abs(ray.step[main])) main = axis;
  }
  const float scale = 1 / std::abs(ray.step[main]);
  const bool rises = ray.step[main] > 0;
  const float origin = ray.origin[main];
  const float plane = rises != has_eye ? std::ceil(origin) : std::floor(origin);
  const float by = std::abs(plane - origin);
  const float ahead = has_eye ? -by : by;
  if (has_eye) ray.start = by;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    ray.step[axis] = ray.step[axis] * scale;
    ray.origin[axis] = ray.origin[axis] + ahead * ray.step[axis];
  }
  ray.step[main] = rises ? 1.0f : -1.0f;
  ray.origin[main] = plane;
  return ray;
}

inline RayLine with_inverse(RayLine ray) {
  for (std::size_t axis = 0; axis < 3; ++axis) ray.inverse[axis] = 1 / ray.step[axis];
  return ray;
}

inline RaySpan span_of(const RayFrame& f, const RayLine& ray) {
  RaySpan span{ray.start, kRayDone, 2};
  bool is_inner_begin = false;
  bool is_inner_end = false;
  float end = kRayDone;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = [&](float face) { return (face - ray.origin[axis]) * ray.inverse[axis]; };
    const float low = at(f.low[axis]);
    const float high = at(f.high[axis]);
    const bool rises = ray.step[axis] > 0;
    const bool is_inner_low = f.low[axis] > f.whole_low[axis];
    const bool is_inner_high = f.high[axis] < f.whole_high[axis];
    const float first = std::min(low, high);
    const float last = std::max(low, high);
    if (first > span.enter) {
      span.enter = first;
      span.axis = axis;
      is_inner_begin = rises ? is_inner_low : is_inner_high;
    }
    if (last < span.leave) {
      span.leave = last;
      is_inner_end = rises ? is_inner_high : is_inner_low;
    }
    end = std::min(end, std::max(at(f.whole_low[axis]), at(f.whole_high[axis])));
  }
  if (span.enter > span.leave) return {0, -1, span.axis};
  if (is_inner_begin) span.enter = std::ceil(span.enter);
  if (is_inner_end) span.leave = std::min(std::ceil(span.leave), end);
  return span;
}

/// Where the values of a place come from.
inline RayPlace kept_place(const RayCuts* cuts, RayPlace place) {
  if (cuts == nullptr) return place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = std::min(std::max(place[axis], cuts->first[axis]), cuts->last[axis]);
  }
  for (std::size_t i = 0; i < cuts->hole_count; ++i) {
    const RayCuts::Hole& hole = cuts->holes[i];
    float nearest = kRayDone;
    RayPlace moved = place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto move_to = [&](float side, float way) {
        if (!(way < nearest)) return;
        nearest = way;
        moved = place;
        moved[axis] = side;
      };
      move_to(hole.before[axis], place[axis] - hole.before[axis]);
      move_to(hole.behind[axis], hole.behind[axis] - place[axis]);
    }
    // Otherwise it lies beside the hole.
    if (nearest > 0) place = moved;
  }
  return place;
}

}  // namespace octavo
