// A cube of 64^3 voxels as classes, condensed: which of its octants have one class throughout.
//
// Invariants
//   A cube of side 2^k is flagged exactly when it lies inside the block's box and all its voxels
//   have one class.
// Consequences
//   The leaves of the condensed octree in the block are the flagged cubes whose parent is not, and
//   the voxels under no flag: one traversal from the top visits each of them once.
//
// Source  thesis 2.4; the order of the traversal 4.3
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"

namespace octavo {

class ClassBlock {
 public:
  static constexpr int kLevel = 6;
  static constexpr std::int64_t kSide = std::int64_t{1} << kLevel;

  ClassBlock();

  /// Starts a block of `size` voxels, at most 64 along each axis; classes are undefined.
  void reset(const Size3& size);

  const Size3& size() const { return size_; }
  /// The class of a voxel inside `size`.
  std::uint16_t& at(std::int64_t x, std::int64_t y, std::int64_t z) {
    return classes_[static_cast<std::size_t>((z * kSide + y) * kSide + x)];
  }
  std::uint16_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return classes_[static_cast<std::size_t>((z * kSide + y) * kSide + x)];
  }

  /// Finds the cubes of one class. Call it when all classes are set.
  void condense();

  /// Visits the leaves in the order of `octants` at every level: `voxel(corner, class)` for those
  /// of side 1, `cube(corner, side, class)` for larger ones.
  template <class Voxel, class Cube>
  void visit_leaves(const std::array<int, 8>& octants, Voxel&& voxel, Cube&& cube) const {
    visit(kLevel, {0, 0, 0}, octants, voxel, cube);
  }

 private:
  bool is_flagged(int level, const Index3& corner) const {
    const int shift = kLevel - level;
    return flags_[static_cast<std::size_t>(level)][static_cast<std::size_t>(
               (((corner.z >> level) << shift | corner.y >> level) << shift) |
               corner.x >> level)] != 0;
  }
  bool has(const Index3& v) const { return v.x < size_.x && v.y < size_.y && v.z < size_.z; }
  void flag_pairs();
  void flag_level(int level);

  template <class Voxel, class Cube>
  void visit(int level, const Index3& corner, const std::array<int, 8>& octants, Voxel& voxel,
             Cube& cube) const {
    if (is_flagged(level, corner)) {
      return cube(corner, std::int64_t{1} << level, at(corner.x, corner.y, corner.z));
    }
    const std::int64_t half = std::int64_t{1} << (level - 1);
    for (const int octant : octants) {
      const Index3 child{corner.x + half * (octant >> 1 & 1), corner.y + half * (octant & 1),
                         corner.z + half * (octant >> 2 & 1)};
      if (!has(child)) continue;
      if (level == 1) voxel(child, at(child.x, child.y, child.z));
      else visit(level - 1, child, octants, voxel, cube);
    }
  }

  Size3 size_;
  std::vector<std::uint16_t> classes_;                       // [z][y][x], 64 each
  std::array<std::vector<std::uint8_t>, kLevel + 1> flags_;  // of level 1 .. 6, [z][y][x]
};

}  // namespace octavo
