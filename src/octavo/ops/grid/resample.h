// The voxels of one grid out of those of another, box by box, straight from the bricks of a file.
//
// A box is made in tiles; for each the source voxels that it may need are read through the brick
// cache of the reader, and for none the whole volume. Tiles over bricks of one value, and those
// that lie outside the source, are filled without decoding.
//
// A source voxel fills the box around its center: between the last centers and the border of the
// volume the values at the border hold; beyond it is outside. Nothing is interpolated between an
// infinity, or NaN, and another voxel: beside them the nearest voxel counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/grid/affine.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo {

enum class Interpolation : std::uint8_t {
  nearest,  ///< that of core/nearest_voxel.h; halfway, the one with the higher index
  linear,   ///< between 8 voxels
  /// Keys' cubic convolution with a = -0.5 (Catmull-Rom) over 64 voxels: through every voxel, and
  /// beyond the values around where they bend. No B-spline, which ITK calls by this order.
  cubic
};

/// Computes voxels of a grid from those of a level of a file. The reader must outlive this.
class Resampler {
 public:
  /// to_source  from voxel indices of the grid to those of `level`
  /// outside    the stored value of voxels outside the source, a voxel of its type
  /// Throws     Error{invalid_argument} for a level that is not there or a map that is not finite
  Resampler(const FileReader& source, int level, const Affine& to_source,
            Interpolation interpolation, double outside);

  /// Writes the voxels of `box` of the grid, of the source's type, to `voxels`, [z][y][x] without
  /// gaps. Integers are rounded to the nearest, halves up, and held within their type. Uses the
  /// threads of the calling task arena; the result does not depend on their number or on how the
  /// grid is cut into boxes. Thread-safe.
  /// Throws what the reader throws
  /// Memory  32 MiB per thread, besides the reader's cache
  void fill(const Box& box, std::byte* voxels) const;

 private:
  class Tile;

  void fill_tile(const Box& tile, const Box& box, std::byte* voxels) const;

  const FileReader& source_;
  int level_;
  Affine to_source_;
  Interpolation interpolation_;
  double outside_;
  Size3 size_;  // of the level
};

/// The mask on another grid: voxels of it whose nearest voxel of `labels` lies in one of `windows`.
/// Uses the threads of the calling task arena.
/// to_source  from voxel indices of the grid to those of `labels`
/// size       of the grid
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the mask grows beyond it
/// Throws     what the reader throws, Error{cancelled}
MaskTree resampled_mask(const FileReader& labels, const Affine& to_source, const Size3& size,
                        std::span<const ValueWindow> windows, Progress& progress,
                        std::uint64_t max_bytes = 0);

}  // namespace octavo
