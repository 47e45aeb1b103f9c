// Single voxels of a mask, asked for in any order, many millions a second.
//
// A table with an entry for every cube of 16^3 voxels of the volume says whether it is empty, full
// or where it is stored. So a voxel costs three reads instead of one for every rank above it:
//
//     table[z / 16][y / 16][x / 16]  ->  cube of 16^3  ->  word of 4^3  ->  bit
//
// In a volume so large that the table would outgrow the tree its entries stand for cubes of 64^3,
// 256^3, ... and the ranks below are visited.
//
// Source  thesis 1.2 (membership)
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/octree/mask_tree.h"

namespace octavo {

/// Immutable; serves any number of threads. The mask must outlive this and stay as it is.
/// Memory  4 bytes for each 16^3 voxels of the volume, but not above that of the mask or 1 MiB
class MaskAccessor {
 public:
  /// Throws Error{limit_exceeded} for a mask of 2^32 - 2 cubes of a rank or more. O(table)
  explicit MaskAccessor(const MaskTree& mask);

  /// Whether a voxel is in the mask; false outside the volume.
  bool contains(const Index3& voxel) const noexcept {
    const bool is_inside = static_cast<std::uint64_t>(voxel.x) < width_ &&
                           static_cast<std::uint64_t>(voxel.y) < height_ &&
                           static_cast<std::uint64_t>(voxel.z) < depth_;
    if (!is_inside) return false;
    const std::int64_t cell =
        ((voxel.z >> shift_) * rows_ + (voxel.y >> shift_)) * columns_ + (voxel.x >> shift_);
    const std::uint32_t entry = table_[static_cast<std::size_t>(cell)];
    if (entry < kFirstStored) return entry == kFull;
    if (rank_ > 0) return contains_below(entry - kFirstStored, voxel);
    const std::uint32_t code = kSpread[voxel.z & 15] << 2 | kSpread[voxel.x & 15] << 1 |
                               kSpread[voxel.y & 15];
    const MaskCube& cube = cubes_[entry - kFirstStored];
    const auto bit = static_cast<int>(code >> 6);
    if ((cube.mixed >> bit & 1) == 0) return (cube.full >> bit & 1) != 0;
    return (words_[cube.place_of(bit)] >> (code & 63) & 1) != 0;
  }

  std::uint64_t memory_bytes() const noexcept {
    return table_.capacity() * sizeof(std::uint32_t);
  }

 private:
  // What an entry says: empty, full, or the place of the cube and 2.
  static constexpr std::uint32_t kFull = 1;
  static constexpr std::uint32_t kFirstStored = 2;

  // The bits of 0..15, each two places further up than the one before.
  static constexpr std::uint32_t kSpread[16] = {
      00000, 00001, 00010, 00011, 00100, 00101, 00110, 00111,
      01000, 01001, 01010, 01011, 01100, 01101, 01110, 01111};

  bool contains_below(std::uint32_t place, const Index3& voxel) const noexcept;

  const MaskTree& mask_;
  const MaskCube* cubes_;          // of the table's rank
  const std::uint64_t* words_;
  std::uint64_t width_;
  std::uint64_t height_;
  std::uint64_t depth_;
  int rank_ = 0;                   // of the cubes that entries stand for
  int shift_ = 4;                  // from voxels to entries
  std::int64_t columns_ = 0;
  std::int64_t rows_ = 0;
  std::vector<std::uint32_t> table_;
};

}  // namespace octavo
