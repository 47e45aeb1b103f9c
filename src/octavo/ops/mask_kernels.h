// The inner loops of masks, for every instruction set that Highway knows, chosen at run time.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/codec/brick_codec.h"

namespace octavo {

/// Voxels in a row of words that are tested at once.
inline constexpr std::int64_t kMaskRun = 64;

/// Bit x of rows[4 * z + y] says whether lowest <= voxel <= highest for voxel (x, y, z) of `block`;
/// rows and bits behind its end are 0.
/// block            at most 64 x 4 x 4 voxels
/// lowest, highest  of the block's voxel type
void rows_in_window(const BrickView& block, const void* lowest, const void* highest,
                    std::array<std::uint64_t, 16>& rows);

/// Sums over voxels near a corner: xx, yy, zz, xy, xz, yz in `second`.
struct SmallSums {
  std::int64_t count = 0;
  std::array<std::int64_t, 3> first{};
  std::array<std::int64_t, 6> second{};
};

/// Sums over the bits of a word, whose coordinates are 0..3.
SmallSums sums_of_bits(std::uint64_t word);

/// Sums over the voxels of the stored words of a cube of 16^3, from its corner.
/// mixed  the children that are stored
/// words  as many
SmallSums sums_of_words(std::uint64_t mixed, const std::uint64_t* words);

}  // namespace octavo
