#include "octavo/core/levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr double kThickRatio = 2;
constexpr int kMaxWaitingLevels = 4;

bool is_single(const Size3& size) { return size.x == 1 && size.y == 1 && size.z == 1; }

[[noreturn]] void bad_ladder(const char* what) {
  throw Error(ErrorKind::corrupt, std::string("halved axes: ") + what);
}

}  // namespace

std::int64_t checked_voxel_count(const Size3& size) {
  for (int axis = 0; axis < 3; ++axis) {
    if (size[axis] < 1 || size[axis] > kMaxAxis) {
      throw Error(ErrorKind::limit_exceeded,
                  "size " + std::to_string(size.x) + " x " + std::to_string(size.y) + " x " +
                      std::to_string(size.z) + "; every axis must be between 1 and " +
                      std::to_string(kMaxAxis));
    }
  }
  if (size == Size3{kMaxAxis, kMaxAxis, kMaxAxis}) {
    throw Error(ErrorKind::limit_exceeded, "2^63 voxels; there must be fewer");
  }
  return size.voxel_count();
}

Size3 halved(const Size3& size, HalvingMask mask) {
  Size3 result = size;
  for (int axis = 0; axis < 3; ++axis) {
    if (mask >> axis & 1) result[axis] = (size[axis] + 1) / 2;
  }
  return result;
}

std::vector<HalvingMask> choose_halvings(const Size3& size, const Point3& spacing_mm) {
  std::vector<HalvingMask> halvings;
  Size3 current = size;
  Point3 spacing = spacing_mm;
  while (!is_single(current)) {
    double finest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      if (current[axis] > 1) finest = std::min(finest, spacing[static_cast<std::size_t>(axis)]);
    }
    HalvingMask mask = 0;
    const bool may_wait = halvings.size() < kMaxWaitingLevels;
    for (int axis = 0; axis < 3; ++axis) {
      double& step = spacing[static_cast<std::size_t>(axis)];
      if (may_wait && current[axis] > 1 && step >= kThickRatio * finest) continue;
      mask = static_cast<HalvingMask>(mask | 1 << axis);
      step *= 2;
    }
    halvings.push_back(mask);
    current = halved(current, mask);
  }
  return halvings;
}

Levels::Levels(const Size3& size, std::vector<HalvingMask> halvings)
    : halvings_(std::move(halvings)) {
  checked_voxel_count(size);
  if (halvings_.size() >= kMaxLevels) bad_ladder("more than 32 levels");
  sizes_.push_back(size);
  for (const HalvingMask mask : halvings_) {
    if (mask > kHalveAll) bad_ladder("unknown bits");
    const Size3 next = halved(sizes_.back(), mask);
    if (next == sizes_.back()) bad_ladder("a level that halves nothing");
    sizes_.push_back(next);
  }
  if (!is_single(sizes_.back())) bad_ladder("the last level is not a single sample");
  for (int tier = 0; tier + 1 < tier_count(); ++tier) {
    for (int axis = 0; axis < 3; ++axis) {
      if (brick_side(tier)[axis] < 4 && this->size(first_level(tier))[axis] > 4) {
        bad_ladder("bricks thinner than 4 samples");
      }
    }
  }
}

HalvingMask Levels::halving(int level) const {
  const auto i = static_cast<std::size_t>(level);
  return i < halvings_.size() ? halvings_[i] : HalvingMask{0};
}

int Levels::halving_count(int level, int axis) const {
  int count = 0;
  for (int k = 0; k < level; ++k) count += halving(k) >> axis & 1;
  return count;
}

Geometry Levels::geometry(const Geometry& level0, int level) const {
  Geometry result = level0;
  Point3 center{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double factor = std::ldexp(1.0, halving_count(level, axis));
    result.spacing_mm[a] = level0.spacing_mm[a] * factor;
    center[a] = (factor - 1) / 2;
  }
  result.origin_mm = level0.to_world(center);
  return result;
}

int Levels::tier_level_count(int tier) const {
  return std::min(kTierLevels, count() - first_level(tier));
}

Size3 Levels::brick_side(int tier) const {
  Size3 side{1, 1, 1};
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kTierLevels; ++i) {
      const int level = first_level(tier) + i;
      // Above the root every axis counts as halved: the last tier has one brick.
      const int is_halved = level + 1 < count() ? halving(level) >> axis & 1 : 1;
      side[axis] <<= is_halved;
    }
  }
  return side;
}

Size3 Levels::brick_grid(int tier) const {
  if (tier + 1 < tier_count()) return size(first_level(tier + 1));
  return {1, 1, 1};
}

Box Levels::brick_box(int tier, const Index3& brick) const {
  const Size3 side = brick_side(tier);
  const Size3& total = size(first_level(tier));
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[axis] = brick[axis] * side[axis];
    box.hi[axis] = std::min(box.lo[axis] + side[axis], total[axis]);
  }
  return box;
}

BrickShape brick_shape(const Levels& levels, int tier, const Index3& brick) {
  BrickShape shape;
  shape.first_level = Levels::first_level(tier);
  shape.level_count = levels.tier_level_count(tier);
  const Box box = levels.brick_box(tier, brick);
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t each = std::int64_t{1} << levels.halving_count(shape.first_level, axis);
    const std::int64_t left = levels.size(0)[axis] - (box.hi[axis] - 1) * each;
    shape.weights.each[axis] = each;
    shape.weights.last[axis] = std::min(each, left);
  }
  Size3 size = box.size();
  for (int i = 0; i < shape.level_count; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    shape.size[slot] = size;
    shape.halving[slot] = levels.halving(shape.first_level + i);
    size = halved(size, shape.halving[slot]);
  }
  return shape;
}

SampleWeights weights_of(const BrickShape& shape, int level) {
  SampleWeights weights = shape.weights;
  for (int i = 0; i < level; ++i) {
    const auto slot = static_cast<std::size_t>(i);
    for (int axis = 0; axis < 3; ++axis) {
      if ((shape.halving[slot] >> axis & 1) == 0) continue;
      const bool has_partner = shape.size[slot][axis] % 2 == 0;
      if (has_partner) weights.last[axis] += weights.each[axis];
      weights.each[axis] *= 2;
    }
  }
  return weights;
}

}  // namespace octavo
