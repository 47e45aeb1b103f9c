// The children of an octant inside a brick, under the halving mask of their level.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/core/levels.h"
#include "octavo/core/voxel_type.h"

namespace octavo {

/// Whether the children with digit 4z + 2x + y exist at all under `mask`.
constexpr bool is_child_digit(HalvingMask mask, int digit) {
  return ((digit >> 1 & 1) == 0 || (mask & 1) != 0) && ((digit & 1) == 0 || (mask & 2) != 0) &&
         ((digit >> 2 & 1) == 0 || (mask & 4) != 0);
}

/// The position of the child with `digit` of the octant at `parent`; it may lie outside the level.
constexpr Index3 child_position(HalvingMask mask, const Index3& parent, int digit) {
  return {(parent.x << (mask & 1)) + (digit >> 1 & 1), (parent.y << (mask >> 1 & 1)) + (digit & 1),
          (parent.z << (mask >> 2 & 1)) + (digit >> 2 & 1)};
}

/// Where the children of an octant stand in an array with these strides, from the first one.
constexpr std::array<std::ptrdiff_t, 8> child_steps(HalvingMask mask, std::ptrdiff_t row,
                                                    std::ptrdiff_t plane) {
  std::array<std::ptrdiff_t, 8> steps{};
  for (std::size_t digit = 0; digit < 8; ++digit) {
    const Index3 at = child_position(mask, {0, 0, 0}, static_cast<int>(digit));
    steps[digit] = at.z * plane + at.y * row + at.x;
  }
  return steps;
}

/// Calls visit(digit, position) for the 1 .. 8 children inside a level of `size`, by rising digit.
template <class Visit>
void for_each_child(const Size3& size, HalvingMask mask, const Index3& parent, Visit&& visit) {
  for (int digit = 0; digit < 8; ++digit) {
    if (!is_child_digit(mask, digit)) continue;
    const Index3 child = child_position(mask, parent, digit);
    if (child.x < size.x && child.y < size.y && child.z < size.z) visit(digit, child);
  }
}

/// The digits of the children inside a level of `size`, bit d for digit d.
constexpr std::uint32_t child_digits(const Size3& size, HalvingMask mask, const Index3& parent) {
  const auto has_both = [&](int axis) {
    return (mask >> axis & 1) != 0 && 2 * parent[axis] + 1 < size[axis];
  };
  return (has_both(0) ? 0xffu : 0x33u) & (has_both(1) ? 0xffu : 0x55u) &
         (has_both(2) ? 0xffu : 0x0fu);
}

/// How many voxels of level 0 lie below the children of an octant, by digit; where they are as many
/// below each, 1.
using ChildWeights = std::array<std::int64_t, 8>;
inline constexpr ChildWeights kAlikeChildren = {1, 1, 1, 1, 1, 1, 1, 1};

/// What the children of these digits weigh together.
constexpr std::int64_t sum_of(const ChildWeights& weights, std::uint32_t digits) {
  std::int64_t sum = 0;
  for (std::size_t digit = 0; digit < 8; ++digit) {
    if ((digits >> digit & 1) != 0) sum += weights[digit];
  }
  return sum;
}

/// The weights of the children in a level: alike but for those at the border of the volume.
class LevelWeights {
 public:
  LevelWeights() = default;
  LevelWeights(const BrickShape& shape, int level) {
    const auto i = static_cast<std::size_t>(level);
    const SampleWeights weights = weights_of(shape, level);
    const Size3 parents = halved(shape.size[i], shape.halving[i]);
    for (int axis = 0; axis < 3; ++axis) {
      if ((shape.halving[i] >> axis & 1) == 0) continue;
      pairs_[static_cast<std::size_t>(axis)] = weights.last_pair(axis, shape.size[i][axis]);
      if (!pairs_[static_cast<std::size_t>(axis)].are_equal()) uneven_[axis] = parents[axis] - 1;
    }
  }

  bool are_alike(const Index3& parent) const {
    return parent.x != uneven_.x && parent.y != uneven_.y && parent.z != uneven_.z;
  }
  ChildWeights of(const Index3& parent) const {
    ChildWeights weights = kAlikeChildren;
    for (int axis = 0; axis < 3; ++axis) {
      if (parent[axis] != uneven_[axis]) continue;
      const PairWeights& pair = pairs_[static_cast<std::size_t>(axis)];
      const int bit = axis == 0 ? 1 : axis == 1 ? 0 : 2;
      for (std::size_t digit = 0; digit < 8; ++digit) {
        weights[digit] *= (digit >> bit & 1) != 0 ? pair.second : pair.first;
      }
    }
    return weights;
  }

 private:
  std::array<PairWeights, 3> pairs_;
  Index3 uneven_{-1, -1, -1};  ///< where along each axis the children of octants weigh unlike
};

inline std::size_t dense_offset(const Size3& size, const Index3& at) {
  return static_cast<std::size_t>((at.z * size.y + at.y) * size.x + at.x);
}

/// Throws Error{invalid_argument} unless the levels of `shape` are those of a brick: sides of 1 to
/// 64, each level the halved one below, and a single sample after the last halving.
void check_label_shape(const BrickShape& shape);

/// Throws Error{invalid_argument} for float32.
void check_label_type(VoxelType type);

}  // namespace octavo
