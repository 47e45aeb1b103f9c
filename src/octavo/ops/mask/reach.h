// How far a voxel reaches when a mask grows: a set of steps (x, y, z) around it.
//
// Invariants
//   With a step the set holds every step that is no longer along any axis, and the same mirrored.
// Consequences
//   For each y and z the set is one run along x, as long as a table of |y| and |z| tells.
//   What a voxel inside a mask reaches is reached from the surface as well, or lies in the mask: a
//   voxel on the way there reaches it too.
//   A box reaches another where its nearest voxel does, and covers it where its farthest does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo {

class Reach {
 public:
  /// Steps of at most `radius_mm` from center to center, within the tolerance of sizes.
  /// size  of the volume: longer steps are left out
  /// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the table would be larger
  /// Throws  Error{invalid_argument} on a radius below 0 or not finite
  /// Memory  4 bytes per pair of steps along y and z
  static Reach within_mm(double radius_mm, const Point3& spacing_mm, const Size3& size,
                         std::uint64_t max_bytes = 0);

  /// What `count` steps from voxel to neighbor reach. size, max_bytes: as within_mm
  /// Throws  Error{invalid_argument} on a count below 0
  static Reach in_steps(std::int64_t count, Connectivity connectivity, const Size3& size,
                        std::uint64_t max_bytes = 0);

  /// Bytes of the table.
  std::uint64_t memory_bytes() const { return runs_.size() * sizeof(std::int32_t); }

  /// The longest step along each axis.
  const Index3& longest() const { return longest_; }

  /// The longest step along x beside y and z, which are not negative; -1: there is none.
  std::int64_t along_x(std::int64_t y, std::int64_t z) const {
    if (y > longest_.y || z > longest_.z) return -1;
    return runs_[static_cast<std::size_t>(z * (longest_.y + 1) + y)];
  }

  /// Whether a step is in the set; none of its parts is negative.
  bool contains(const Index3& step) const { return along_x(step.y, step.z) >= step.x; }

 private:
  /// run(y, z): the longest step along x, or less than 0.
  template <class Run>
  Reach(const Index3& longest, std::uint64_t max_bytes, Run run);

  Index3 longest_;
  std::vector<std::int32_t> runs_;  // [z][y]
};

}  // namespace octavo
