// A cube of a tree with the 26 cubes of its size around it, and the same one rank further down.
//
// Places are numbered 9 (z + 1) + 3 (y + 1) + x + 1 for steps x, y, z of -1, 0 or 1; the cube
// itself stands at 13. What lies outside the universe is empty.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo {

inline constexpr std::size_t kCenter = 13;

using CubesAround = std::array<MaskCube, 27>;
using WordsAround = std::array<std::uint64_t, 27>;

/// The step from the center to a place.
constexpr Direction direction_to(std::size_t place) noexcept {
  const auto at = static_cast<int>(place);
  return {at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1};
}

/// Whether what stands at a place may touch the center.
constexpr bool is_near(std::size_t place, Connectivity connectivity) noexcept {
  const Direction d = direction_to(place);
  const int steps = d.x * d.x + d.y * d.y + d.z * d.z;
  return steps <= (connectivity == Connectivity::faces   ? 1
                   : connectivity == Connectivity::edges ? 2
                                                         : 3);
}

namespace neighborhood_detail {

/// Where a child stands: in which of the 27 cubes, and there at which bit.
struct ChildPlace {
  std::uint8_t cube = 0;
  std::uint8_t bit = 0;
};

constexpr std::array<std::array<ChildPlace, 27>, 64> kChildPlaces = [] {
  constexpr int kWeight[3] = {1, 3, 9};
  std::array<std::array<ChildPlace, 27>, 64> places{};
  for (int child = 0; child < 64; ++child) {
    for (std::size_t to = 0; to < 27; ++to) {
      const Direction d = direction_to(to);
      const int steps[3] = {d.x, d.y, d.z};
      int cube = 0;
      int bit = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const int at =
            (child >> kLowPlace[axis] & 1) + 2 * (child >> kHighPlace[axis] & 1) + steps[axis];
        cube += kWeight[axis] * (at < 0 ? 0 : at > 3 ? 2 : 1);
        bit |= (at & 1) << kLowPlace[axis] | (at >> 1 & 1) << kHighPlace[axis];
      }
      places[static_cast<std::size_t>(child)][to] = {static_cast<std::uint8_t>(cube),
                                                     static_cast<std::uint8_t>(bit)};
    }
  }
  return places;
}();

}  // namespace neighborhood_detail

/// The root with nothing around it.
inline CubesAround around_root(const MaskTree& tree) noexcept {
  CubesAround around{};
  around[kCenter] = tree.root();
  return around;
}

/// The child at `bit` of the center of `around`, cubes of `rank`, with the cubes of the same size
/// that may touch it; the others are left empty. Requires rank > 0.
inline CubesAround cubes_around_child(const MaskTree& tree, int rank, const CubesAround& around,
                                      int bit, Connectivity connectivity) noexcept {
  CubesAround made{};
  const auto& places = neighborhood_detail::kChildPlaces[static_cast<std::size_t>(bit)];
  for (std::size_t to = 0; to < made.size(); ++to) {
    if (!is_near(to, connectivity)) continue;
    const MaskCube& parent = around[places[to].cube];
    if ((parent.mixed >> places[to].bit & 1) != 0) {
      made[to] = tree.cubes(rank - 1)[parent.place_of(places[to].bit)];
    } else {
      made[to].full = -(parent.full >> places[to].bit & 1);
    }
  }
  return made;
}

/// The word at `bit` of the center of `around`, cubes of rank 0, with the words that may touch it.
inline WordsAround words_around_child(const MaskTree& tree, const CubesAround& around, int bit,
                                      Connectivity connectivity) noexcept {
  WordsAround made{};
  const auto& places = neighborhood_detail::kChildPlaces[static_cast<std::size_t>(bit)];
  for (std::size_t to = 0; to < made.size(); ++to) {
    if (!is_near(to, connectivity)) continue;
    const MaskCube& parent = around[places[to].cube];
    if ((parent.mixed >> places[to].bit & 1) != 0) {
      made[to] = tree.words()[parent.place_of(places[to].bit)];
    } else {
      made[to] = -(parent.full >> places[to].bit & 1);
    }
  }
  return made;
}

/// The bits of the center that are in one of the words or touch one.
inline std::uint64_t touched_from(const WordsAround& words, Connectivity connectivity) noexcept {
  std::uint64_t bits = touched(words[kCenter], connectivity);
  for (std::size_t from = 0; from < words.size(); ++from) {
    if (from == kCenter || words[from] == 0 || !is_near(from, connectivity)) continue;
    bits |= touched_beyond(words[from], direction_to(from).reversed(), connectivity);
  }
  return bits;
}

/// The bits of the center whose neighbor one step in `sign` (1 or -1) along an axis is in the
/// words.
inline std::uint64_t beside_along(const WordsAround& words, int axis, int sign) noexcept {
  constexpr std::array<std::size_t, 3> kWeight = {1, 3, 9};
  const std::size_t weight = kWeight[static_cast<std::size_t>(axis)];
  const std::size_t from = sign > 0 ? kCenter + weight : kCenter - weight;
  const std::uint64_t inside =
      sign > 0 ? step_down(words[kCenter], axis) : step_up(words[kCenter], axis);
  return inside | touched_beyond(words[from], direction_to(from).reversed(), Connectivity::faces);
}

}  // namespace octavo
