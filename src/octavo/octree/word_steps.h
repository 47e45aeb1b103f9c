// Steps inside words of 4 x 4 x 4 children in o-code order, all at a time by shifts.
//
// Bit c stands at z, x, y whose bits are interleaved in c (z1 x1 y1 z0 x0 y0), so a step of one
// along an axis moves bits by two distances: from even to odd inside an octant, from odd to even
// across.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/core/box.h"

namespace octavo {

/// Where bits 0 and 1 of x, y and z stand in the number of a bit.
inline constexpr std::array<int, 3> kLowPlace = {1, 0, 2};
inline constexpr std::array<int, 3> kHighPlace = {4, 3, 5};

namespace word_detail {

// The bits at which an axis has a coordinate, [axis][0..3].
constexpr std::array<std::array<std::uint64_t, 4>, 3> kSlabs = [] {
  std::array<std::array<std::uint64_t, 4>, 3> slabs{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (int bit = 0; bit < 64; ++bit) {
      const int at = (bit >> kLowPlace[axis] & 1) + 2 * (bit >> kHighPlace[axis] & 1);
      slabs[axis][static_cast<std::size_t>(at)] |= std::uint64_t{1} << bit;
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

/// Where a bit of a word, or of the children of a cube, stands in 4^3.
constexpr Index3 place_of_bit(int bit) noexcept {
  const auto along = [&](std::size_t axis) {
    return std::int64_t{(bit >> kLowPlace[axis] & 1) +
                        2 * (bit >> kHighPlace[axis] & 1)};
  };
  return {along(0), along(1), along(2)};
}

/// The bit at a place.
constexpr int bit_of_place(const Index3& at) noexcept {
  std::int64_t bit = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t along = at[static_cast<int>(axis)];
    bit |= (along & 1) << kLowPlace[axis] | along >> 1 << kHighPlace[axis];
  }
  return static_cast<int>(bit);
}

/// The bits of the voxels of a word that lie less than `size` from its corner; 0 where an axis has
/// none.
constexpr std::uint64_t bits_within(const Size3& size) noexcept {
  std::uint64_t bits = ~std::uint64_t{0};
  for (int axis = 0; axis < 3; ++axis) {
    std::uint64_t slabs = 0;
    for (int at = 0; at < 4 && at < size[axis]; ++at) slabs |= slab_of(axis, at);
    bits &= slabs;
  }
  return bits;
}

/// Every bit one step up an axis; those at 3 fall out.
constexpr std::uint64_t step_up(std::uint64_t word, int axis) noexcept {
  const auto a = static_cast<std::size_t>(axis);
  const std::uint64_t even = slab_of(axis, 0) | slab_of(axis, 2);
  return (word & even) << word_detail::kStep[a] | (word & slab_of(axis, 1))
                                                      << word_detail::kAcross[a];
}

/// Every bit one step down an axis; those at 0 fall out.
constexpr std::uint64_t step_down(std::uint64_t word, int axis) noexcept {
  const auto a = static_cast<std::size_t>(axis);
  const std::uint64_t odd = slab_of(axis, 1) | slab_of(axis, 3);
  return (word & odd) >> word_detail::kStep[a] |
         (word & slab_of(axis, 2)) >> word_detail::kAcross[a];
}

}  // namespace octavo
