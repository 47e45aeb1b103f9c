// Neighborhoods inside words of 4 x 4 x 4 children in o-code order, many at a time by shifts.
//
// Bit c stands at z, x, y whose bits are interleaved in c (z1 x1 y1 z0 x0 y0), so a step of one
// along an axis moves bits by two distances: from even to odd inside an octant, from odd to even
// across.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/core/o_code.h"

namespace octavo {

/// Which voxels touch: those that share a face, a face or an edge, or a corner as well.
enum class Connectivity : std::uint8_t { faces = 6, edges = 18, corners = 26 };

namespace word_detail {

// The bits at which an axis has a coordinate, [axis][0..3].
constexpr std::array<std::array<std::uint64_t, 4>, 3> kSlabs = [] {
  // Where bits 0 and 1 of a coordinate stand in the index of a bit.
  constexpr int kLow[3] = {1, 0, 2};
  constexpr int kHigh[3] = {4, 3, 5};
  std::array<std::array<std::uint64_t, 4>, 3> slabs{};
  for (int axis = 0; axis < 3; ++axis) {
    for (int bit = 0; bit < 64; ++bit) {
      const int at = (bit >> kLow[axis] & 1) + 2 * (bit >> kHigh[axis] & 1);
      slabs[static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)] |= std::uint64_t{1}
                                                                             << bit;
    }
  }
  return slabs;
}();

// One step inside an octant, and how far the coordinate 3 is from 0.
constexpr std::array<int, 3> kStep = {2, 1, 4};
constexpr std::array<int, 3> kAcross = {14, 7, 28};  // from 1 to 2
constexpr std::array<int, 3> kWhole = {18, 9, 36};   // from 0 to 3

}  // namespace word_detail

/// The bits with coordinate `at` (0..3) on `axis`.
constexpr std::uint64_t slab_of(int axis, int at) noexcept {
  return word_detail::kSlabs[static_cast<std::size_t>(axis)][static_cast<std::size_t>(at)];
}

/// Every bit one step up an axis; those at 3 fall out.
constexpr std::uint64_t step_up(std::uint64_t word, int axis) noexcept {
  const auto a = static_cast<std::size_t>(axis);
  const std::uint64_t even = slab_of(axis, 0) | slab_of(axis, 2);
  return (word & even) << word_detail::kStep[a] |
         (word & slab_of(axis, 1)) << word_detail::kAcross[a];
}

/// Every bit one step down an axis; those at 0 fall out.
constexpr std::uint64_t step_down(std::uint64_t word, int axis) noexcept {
  const auto a = static_cast<std::size_t>(axis);
  const std::uint64_t odd = slab_of(axis, 1) | slab_of(axis, 3);
  return (word & odd) >> word_detail::kStep[a] |
         (word & slab_of(axis, 2)) >> word_detail::kAcross[a];
}

/// `word` and what lies one step from it on `axis`.
constexpr std::uint64_t spread_along(std::uint64_t word, int axis) noexcept {
  return word | step_up(word, axis) | step_down(word, axis);
}

/// `word` and what touches it, along the axes with `axes[axis]` set.
constexpr std::uint64_t touched(std::uint64_t word, Connectivity connectivity,
                                const std::array<bool, 3>& axes = {true, true, true}) noexcept {
  std::uint64_t one = word;    // what shares a face
  std::uint64_t two = word;    // a face or an edge
  std::uint64_t three = word;  // a face, an edge or a corner
  for (int axis = 0; axis < 3; ++axis) {
    if (!axes[static_cast<std::size_t>(axis)]) continue;
    const std::uint64_t next_three = spread_along(three, axis);
    const std::uint64_t next_two = two | spread_along(one, axis);
    const std::uint64_t next_one = one | spread_along(word, axis);
    one = next_one;
    two = next_two | next_one;
    three = next_three;
  }
  switch (connectivity) {
    case Connectivity::faces: return one;
    case Connectivity::edges: return two;
    case Connectivity::corners: break;
  }
  return three;
}

/// The bits of the next word in `direction` that touch bits of `word`.
constexpr std::uint64_t touched_beyond(std::uint64_t word, const Direction& direction,
                                       Connectivity connectivity) noexcept {
  const std::array<int, 3> steps = {direction.x, direction.y, direction.z};
  std::array<bool, 3> is_free{};
  int crossed = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    is_free[a] = steps[a] == 0;
    crossed += steps[a] != 0 ? 1 : 0;
    if (steps[a] > 0) word = (word & slab_of(axis, 3)) >> word_detail::kWhole[a];
    if (steps[a] < 0) word = (word & slab_of(axis, 0)) << word_detail::kWhole[a];
  }
  // Each axis crossed is a step already taken.
  const int left = (connectivity == Connectivity::faces   ? 1
                    : connectivity == Connectivity::edges ? 2
                                                          : 3) - crossed;
  if (left < 0) return 0;
  if (left == 0) return word;
  return touched(word, left == 1 ? Connectivity::faces : Connectivity::edges, is_free);
}

/// The bits of a word connected with those of `seed` through `word`. Requires seed within word.
constexpr std::uint64_t flood(std::uint64_t word, std::uint64_t seed,
                              Connectivity connectivity) noexcept {
  for (;;) {
    const std::uint64_t grown = touched(seed, connectivity) & word;
    if (grown == seed) return seed;
    seed = grown;
  }
}

}  // namespace octavo
