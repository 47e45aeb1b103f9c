// Leaves of an octree split until neighbors differ by one level: over faces, edges and corners,
// inside the object alone.
//
// A cell is split when leaves smaller than it lie in it. Levels go from fine to coarse: a cell of
// level k + 1 that lies in a leaf is split where a split cell of level k touches it, or touches a
// cell of level k in it:
//
//     split, level k  ##..........        the leaf beside it, level k + 2, falls into leaves of
//                     ##. . . . . .       level k there and of level k + 1 behind
//
// Levels 1 to 3 are rows of bits in blocks of 16^3 voxels, dilated and halved by shifts; a block
// and those that touch it decide. Above them blocks are cells themselves.
//
// Invariants  of what balanced_leaves gives
//   The leaves fill the same voxels. Any two that touch differ by one level at most.
// Consequences
//   A corner of one leaf that lies on the border of another is a corner of it, or the middle of one
//   of its edges or faces. The corners at the ends of that edge or face hang nowhere themselves.
//
// Source  Tu, O'Hallaron, Ghattas, Scalable parallel octree meshing for terascale applications,
//         2005, for the order of levels
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/octree/o_code.h"

namespace octavo {

/// Takes the leaves of an octree, the sooner in o-code order the faster.
class LeafBalance {
 public:
  LeafBalance();
  ~LeafBalance();
  LeafBalance(const LeafBalance&) = delete;
  LeafBalance& operator=(const LeafBalance&) = delete;

  /// Requires a leaf that no other one meets.
  void add(const OCode& leaf);

  /// Bytes of all that was added, and what `finish` adds to it for blocks that are not yet there.
  std::uint64_t memory_bytes() const noexcept;

  /// The balanced leaves in o-code order. Uses the threads of the calling task arena; the result
  /// does not depend on their number. Call it once.
  /// Throws  Error{cancelled}
  /// Memory  800 bytes for each cube of 16^3 voxels with leaves below it or beside such, 16 a leaf
  std::vector<OCode> finish(const Progress& watcher = NoProgress());

 private:
  class Blocks;
  std::unique_ptr<Blocks> blocks_;
};

}  // namespace octavo
