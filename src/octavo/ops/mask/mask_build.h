// Masks from voxels: planes or blocks in, a tree out.
//
// A layer of 64 planes is held as bits, one per voxel, in words of 4^3; when it is complete its
// cubes of 64^3 are folded into sub-trees on all threads. So memory is that of the tree and 8 bytes
// per voxel of a plane.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/mask_pieces.h"

namespace octavo {

/// Voxels of which a mask is made: those with lowest <= value <= highest, in stored units. Every
/// integer voxel is exact in a double; NaN is in no window.
struct ValueWindow {
  double lowest = 0;
  double highest = 0;

  /// NaN and infinities are in no window.
  bool contains(double value) const {
    return lowest <= value && value <= highest && std::isfinite(value);
  }
};

/// Takes the blocks of a volume layer by layer and gives its tree. One thread at a time, but for
/// `add_block`.
class MaskBuilder {
 public:
  /// Planes of a layer.
  static constexpr std::int64_t kLayerPlanes = 64;

  /// Throws Error{limit_exceeded} on a bad size.
  explicit MaskBuilder(const Size3& size);

  /// Adds the voxels of a block that are in the window; its first voxel is at `corner`.
  /// corner  multiples of 4; the block lies inside the layer that is being filled and its sizes are
  ///         multiples of 4 but at the end of the volume
  /// Thread-safe for blocks that do not overlap.
  /// Throws Error{invalid_argument} on other blocks.
  void add_block(const Index3& corner, const BrickView& block, const ValueWindow& window);

  /// Folds the layer; the next 64 planes follow.
  void finish_layer();

  /// Bytes of the layer being filled and of all that was folded, twice over: `finish` copies it.
  std::uint64_t memory_bytes() const;

  /// The tree of all layers. Call it once, after the last layer.
  MaskTree finish();

 private:
  void require_block(const Box& box) const;
  std::uint64_t& word_at(const Index3& voxel);

  Size3 size_;
  Size3 cubes_;  // of 64^3 voxels, per axis
  std::int64_t layer_ = 0;
  std::vector<std::uint64_t> words_;  // of the layer: cube by cube [y][x], in o-code order inside
  std::vector<MaskPart> parts_;       // a cube of 64^3 each
  std::uint64_t part_bytes_ = 0;
};

/// Adds the voxels of a block that are in the window to the words of a cube of 64^3 voxels.
/// corner  of the block in the cube, multiples of 4; the block ends in the cube
/// words   4096 in o-code order
void add_to_cube(const Index3& corner, const BrickView& block, const ValueWindow& window,
                 std::uint64_t* words);

/// The mask of a volume in memory. Uses the threads of the calling task arena.
/// Throws as MaskBuilder
MaskTree make_mask(const BrickView& volume, const ValueWindow& window);

}  // namespace octavo
