// o-codes: the names of the cubes of an octree, as numbers that sort.
//
// The volume lies in a universe cube of side 2^n. Level 0 is the voxel; a cube of level k has side
// 2^k; the root is level n. Digit i of voxel (x, y, z) is d_i = 4*z_i + 2*x_i + y_i, made of bit i
// of each coordinate; the digits d_{n-1} ... d_0, read as one octal number, are its code (a Morton
// order that ranks the axes z, x, y). A cube of level k keeps the n-k leading digits of any voxel
// in it; the root keeps none and its code is 0.
//
//       the eight octants of a cube       y ->         y ->
//                                     x   0 1      x   4 5
//                                     |   2 3      |   6 7
//                                     v  z = 0     v  z = 1
//
// Invariants
//   An OCode is a level k in 0 .. n and a code below 8^(n-k). n <= 21, so a code fits in 63 bits.
// Consequences
//   The parent is code / 8 and the children are 8 * code + 0..7: moving in the tree is shifting.
//   The cubes of level j below a cube of level k have the codes [code * 8^(k-j), (code + 1) *
//   8^(k-j)): in a sorted list per level every sub-tree is one contiguous run, found by binary
//   search.
//   Voxels sorted by code have the eight siblings of every octant side by side, in octant order.
//   A code means nothing without its level, and its digits mean nothing without n.
//
// Two notations. Mixed-octal: n digits, of which the last k are the marker 8; sorting the strings
// gives the post-order of the tree. Linear hierarchical: the n-k digits alone, one sorted list per
// level. With n = 3 the cube of side 2 at (0, 2, 4) is 418 in the first and 41 in the second.
//
// Source  thesis 1.2 and 2.3; the marker is Gargantini's
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "octavo/core/box.h"

namespace octavo {

/// The largest n: 3 * 21 = 63 bits of code.
inline constexpr int kMaxUniverseLevel = 21;

/// The code of a position: bit i of (z, x, y) becomes bits 3i+2, 3i+1, 3i.
/// Requires 0 <= x, y, z < 2^21; higher bits are dropped.
std::uint64_t interleave(const Index3& position) noexcept;

/// The position of a code: the inverse of interleave for codes below 2^63.
Index3 deinterleave(std::uint64_t code) noexcept;

/// One cube of the octree. Compares in hierarchical order: by level, then by code.
struct OCode {
  int level = 0;
  std::uint64_t code = 0;

  auto operator<=>(const OCode&) const = default;
};

/// The root's level n: the smallest cube of side 2^n that holds a grid of `size`.
/// Throws Error{limit_exceeded} when an axis is below 1 or above 2^21.
int universe_level(const Size3& size);

/// True when `cube` lies in the universe of root level n.
bool is_valid(const OCode& cube, int n) noexcept;

/// Side of a cube of `level`, voxels.
constexpr std::int64_t cube_side(int level) noexcept { return std::int64_t{1} << level; }

/// Voxels in a cube of `level`.
constexpr std::uint64_t cube_volume(int level) noexcept { return std::uint64_t{1} << 3 * level; }

/// The cube of `level` that holds a voxel. Requires 0 <= x, y, z < 2^21.
OCode cube_at(const Index3& voxel, int level) noexcept;

/// The voxel of a cube with the lowest coordinates: the inverse of cube_at on multiples of the
/// side.
Index3 corner_of(const OCode& cube) noexcept;

/// The voxels of a cube.
Box box_of(const OCode& cube) noexcept;

/// The place of a cube among its siblings, 0..7: its last digit.
constexpr int octant_of(const OCode& cube) noexcept { return static_cast<int>(cube.code & 7); }

/// The cube one level up. Requires that `cube` is not the root.
constexpr OCode parent_of(const OCode& cube) noexcept { return {cube.level + 1, cube.code >> 3}; }

/// The cube of `level` that contains `cube`. Requires cube.level <= level <= n.
constexpr OCode ancestor_of(const OCode& cube, int level) noexcept {
  return {level, cube.code >> 3 * (level - cube.level)};
}

/// The child in `octant` (0..7). Requires cube.level > 0.
constexpr OCode child_of(const OCode& cube, int octant) noexcept {
  return {cube.level - 1, cube.code << 3 | static_cast<std::uint64_t>(octant)};
}

/// The eight children in octant order. Requires cube.level > 0.
std::array<OCode, 8> children_of(const OCode& cube) noexcept;

/// True when `inner` is `outer` or lies inside it.
constexpr bool contains(const OCode& outer, const OCode& inner) noexcept {
  return inner.level <= outer.level && ancestor_of(inner, outer.level).code == outer.code;
}

/// A step of -1, 0 or 1 along each axis.
struct Direction {
  int x = 0;
  int y = 0;
  int z = 0;

  bool operator==(const Direction&) const = default;
  constexpr Direction reversed() const { return {-x, -y, -z}; }
  /// Whether voxels there come later when z counts first, then y, then x.
  constexpr bool is_forward() const {
    return z > 0 || (z == 0 && (y > 0 || (y == 0 && x > 0)));
  }
};

/// The 26 directions: 6 to faces, then 12 to edges, then 8 to corners.
extern const std::array<Direction, 26> kDirections;

/// The cube of the same level beside `cube`; nothing when that lies outside the universe of root
/// level n. A carry on the spread bits of each axis: no coordinates are made.
std::optional<OCode> neighbor_of(const OCode& cube, const Direction& direction, int n) noexcept;

/// The 26 neighbors in the order of kDirections; those outside the universe are absent.
std::array<std::optional<OCode>, 26> neighbors_of(const OCode& cube, int n) noexcept;

/// True when `a` comes before `b` in post-order (children before their parent), which is the order
/// of the mixed-octal strings. Codes of any two levels of one universe compare.
bool is_before_in_post_order(const OCode& a, const OCode& b) noexcept;

/// n characters: the n-k digits of the cube, then k markers '8'. Requires is_valid(cube, n).
std::string to_mixed_octal(const OCode& cube, int n);

/// The n-k digits of the cube; empty for the root. Requires is_valid(cube, n).
std::string to_hierarchical(const OCode& cube, int n);

/// The cube of a mixed-octal text; n is its length.
/// Throws Error{invalid_argument} on a character other than 0..8, a digit after a marker, or more
/// than 21 characters.
OCode parse_mixed_octal(std::string_view text);

/// The cube of a linear hierarchical text in the universe of root level n.
/// Throws Error{invalid_argument} on a character other than 0..7 or more than n characters.
OCode parse_hierarchical(std::string_view text, int n);

}  // namespace octavo
