// Where two masks meet: the voxels they share, and where one lies against the other.
//
// One traversal of both trees. A cube is entered only when voxels of both lie in it, or voxels of
// one beside voxels of the other; what both fill is counted without being entered. So the work
// follows the places where the masks meet.
//
// Source  thesis 1.2
#pragma once

#include <array>
#include <cstdint>

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo {

/// Some voxels: how many, and their bounding box, which is empty where there are none.
struct VoxelExtent {
  std::uint64_t voxel_count = 0;
  Box box;

  bool operator==(const VoxelExtent&) const = default;
};

/// What two masks a and b have to do with each other.
struct Interference {
  VoxelExtent overlap;    ///< in both
  VoxelExtent contact_a;  ///< in a alone, with a neighbor that is in b alone
  VoxelExtent contact_b;  ///< in b alone, with a neighbor that is in a alone
  /// Pairs of a voxel in a alone and one in b alone that share a face across x, y, z, whatever the
  /// connectivity.
  std::array<std::uint64_t, 3> face_pairs{};

  bool operator==(const Interference&) const = default;
  bool is_overlap() const { return overlap.voxel_count > 0; }
  bool is_contact() const { return contact_a.voxel_count > 0; }
};

/// How two masks meet. Uses the threads of the calling task arena; the result does not depend on
/// their number.
/// connectivity  which voxels are neighbors
/// Throws  Error{invalid_argument} when the volumes differ in size
/// Memory  that of the call stack
Interference interference(const MaskTree& a, const MaskTree& b, Connectivity connectivity);

}  // namespace octavo
