#include "octavo/ops/distance/line_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace octavo {

namespace {

constexpr float kNoDistance = std::numeric_limits<float>::infinity();

}  // namespace

LineDistance::LineDistance(std::int64_t longest, double weight, DistanceTo to)
    : weight_(weight),
      is_to_faces_(to == DistanceTo::faces),
      half_inverse_(static_cast<std::size_t>(longest) + 3),
      envelope_(static_cast<std::size_t>(longest) + 3) {
  for (std::size_t i = 1; i < half_inverse_.size(); ++i) {
    half_inverse_[i] = 1 / (2 * weight * static_cast<double>(i));
  }
}

void LineDistance::begin(std::span<const std::uint8_t> mask, std::span<float> squared) const {
  const std::size_t count = mask.size();
  const double nearest = is_to_faces_ ? 0.5 : 1;
  for (std::size_t lo = 0; lo < count;) {
    const bool is_inside = mask[lo] != 0;
    std::size_t hi = lo + 1;
    while (hi < count && (mask[hi] != 0) == is_inside) ++hi;
    for (std::size_t x = lo; x < hi; ++x) {
      double steps = std::numeric_limits<double>::infinity();
      if (lo > 0) steps = static_cast<double>(x - lo) + nearest;
      if (hi < count) steps = std::min(steps, static_cast<double>(hi - 1 - x) + nearest);
      const auto value = static_cast<float>(weight_ * steps * steps);
      squared[x] = is_inside ? -value : value;
    }
    lo = hi;
  }
}

void LineDistance::improve(std::span<float> squared) {
  for (std::size_t lo = 0; lo < squared.size();) {
    const bool is_inside = std::signbit(squared[lo]);
    std::size_t hi = lo + 1;
    while (hi < squared.size() && std::signbit(squared[hi]) == is_inside) ++hi;
    improve_run(squared, lo, hi);
    lo = hi;
  }
}

void LineDistance::add_parabola(double place, double height) {
  double start = -1;
  while (count_ > 0) {
    const Parabola& last = envelope_[count_ - 1];
    const double apart = place - last.place;
    start = 0.5 * (place + last.place) +
            (height - last.height) * half_inverse_[static_cast<std::size_t>(apart)];
    if (start > last.start) break;
    --count_;
  }
  envelope_[count_++] = {place, height, count_ == 0 ? -1 : start};
}

void LineDistance::improve_run(std::span<float> squared, std::size_t begin, std::size_t end) {
  const bool has_before = begin > 0;
  const bool has_behind = end < squared.size();
  const auto height_at = [&](std::size_t i) { return std::abs(squared[i]); };
  count_ = 0;

  // The parabolas from left to right: on voxels, or on the faces before and behind each.
  if (has_before) add_parabola(static_cast<double>(begin) - (is_to_faces_ ? 0 : 1), 0);
  if (is_to_faces_) {
    for (std::size_t i = begin + 1; i < end; ++i) {
      const float height = std::min(height_at(i - 1), height_at(i));
      if (height != kNoDistance) add_parabola(static_cast<double>(i), height);
    }
  } else {
    for (std::size_t i = begin; i < end; ++i) {
      if (height_at(i) != kNoDistance) add_parabola(static_cast<double>(i), height_at(i));
    }
  }
  if (has_behind) add_parabola(static_cast<double>(end), 0);
  if (count_ == 0) return;

  // The lowest one at each voxel; face i lies half a step before the center of voxel i.
  const float sign = std::signbit(squared[begin]) ? -1.0F : 1.0F;
  const double offset = is_to_faces_ ? 0.5 : 0;
  std::size_t lowest = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const double place = static_cast<double>(i) + offset;
    while (lowest + 1 < count_ && envelope_[lowest + 1].start <= place) ++lowest;
    const double steps = place - envelope_[lowest].place;
    const double value = weight_ * steps * steps + envelope_[lowest].height;
    squared[i] = sign * std::min(static_cast<float>(value), height_at(i));
  }
}

}  // namespace octavo
