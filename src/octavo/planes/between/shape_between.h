// Label planes between two label planes, by the shapes of the labels.
//
// Every label has in both planes a signed distance: how far a pixel lies inside (positive) or
// outside (negative) of it, in pixels, 0 half way between neighbors. In between the distances are
// mixed linearly, and the label whose mixed distance is largest takes the pixel:
//
//     score(L) = (1 - t) * below(L) + t * above(L)
//
// - A pixel with one label in both planes keeps it: no other label is positive there. Only pixels
//   that differ are decided.
// - Labels whose pixels are the same in both planes matter only where they are nearest, so that one
//   distance transform serves all of them.
// - A label that one plane lacks shrinks to nothing half way: there its distance is taken to be as
//   far outside as it reaches inside the other plane, plus its distance in that plane.
// - Of equal scores that of the label of the nearer plane wins (half way: of the lower plane), then
//   that of the other plane, then the smallest label.
//
// Source: Raya, Udupa, "Shape-based interpolation of multidimensional objects" (1990)
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "octavo/core/voxel_type.h"

namespace octavo {

/// Where a plane lies between two: part / whole of the way up.
struct WayUp {
  double part = 0;
  double whole = 1;
};

/// Makes planes between pairs of planes.
class ShapeBetween {
 public:
  virtual ~ShapeBetween() = default;

  /// Bytes held for planes of this size and type, at most.
  static std::uint64_t memory_bytes(std::int64_t columns, std::int64_t rows, VoxelType type);

  /// The most planes that may be asked for at once.
  virtual std::size_t max_ways() const = 0;

  /// Takes a copy of a pair of planes ([y][x]).
  virtual void set_pair(std::span<const std::byte> below, std::span<const std::byte> above) = 0;

  /// Decides the planes at `ways`, 0 < part < whole, at most max_ways() of them.
  /// Time  a few distance transforms for each label that differs
  virtual void decide(std::span<const WayUp> ways) = 0;

  /// Fills `plane` with the plane at ways[index] of the last call of decide.
  virtual void fill(std::size_t index, std::span<std::byte> plane) const = 0;
};

/// Throws Error{invalid_argument} for float32.
std::unique_ptr<ShapeBetween> make_shape_between(std::int64_t columns, std::int64_t rows,
                                                 VoxelType type);

}  // namespace octavo
