// Neighborhoods inside words of 4 x 4 x 4 children in o-code order, many at a time by shifts.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/octree/o_code.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

/// Which voxels touch: those that share a face, a face or an edge, or a corner as well.
enum class Connectivity : std::uint8_t { faces = 6, edges = 18, corners = 26 };

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
