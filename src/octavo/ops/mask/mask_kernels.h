// The inner loops of masks, for every instruction set that Highway knows, chosen at run time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/codec/brick_codec.h"

namespace octavo {

/// Voxels of a run: 16 words side by side.
inline constexpr std::int64_t kMaskRun = 64;

/// Runs that may be worked on at once.
inline constexpr std::size_t kMaskRunsAtOnce = 8;

/// Words of 4^3 voxels in o-code order out of rows of voxels: 16 words side by side of each run of
/// 64 x 4 x 4 voxels.
/// rows    rows[(4 * z + y) * stride + run], bit x the voxel (x, y, z) of the run
/// stride  not below count, rounded up to kMaskRunsAtOnce: so many are read and written
/// words   words[i * stride + run] begins at x = 4 * i
void words_of_rows(const std::uint64_t* rows, std::size_t stride, std::size_t count,
                   std::uint64_t* words);

/// The words of a layer of four rows in four planes.
class RunRows {
 public:
  /// width  voxels of a row
  explicit RunRows(std::int64_t width);

  /// Takes the voxels of a block of at most width x 4 x 4 with lowest <= voxel <= highest.
  /// lowest, highest  of the block's voxel type
  void take(const BrickView& block, const void* lowest, const void* highest);

  /// The 4^3 voxels from x = 4 * i on, in o-code order.
  std::uint64_t word(std::size_t i) const { return words_[i % 16 * stride_ + i / 16]; }

 private:
  std::size_t runs_;
  std::size_t stride_;
  std::vector<std::uint64_t> rows_;   // [z][y][run], a bit per voxel
  std::vector<std::uint64_t> words_;  // [x / 4 % 16][run]
};

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
