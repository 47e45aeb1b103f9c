// The Euler number of a mask: pieces, less tunnels, plus cavities.
//
// It is counted, not searched: as a set of closed cubes, voxels that share a corner hang together
// (26 neighbors), and
//
//     number = corners - edges + faces - voxels
//
// As a set of voxels that hang together by faces alone (6 neighbors), it is voxels less pairs side
// by side, plus squares of four, less cubes of eight. Where a structure is well resolved the two
// agree; how far they are apart tells what the choice is worth.
//
// A mask that is cut out of a larger one has tunnels that its border opens. With what lies in the
// border weighted by half (in an edge of the volume by a quarter, in a corner by an eighth), the
// numbers of neighboring volumes add up, and this one's share of the whole is not biased.
//
// Source  A. Odgaard, H. J. G. Gundersen, Quantification of connectivity in cancellous bone,
//         Bone 14 (1993); J. Toriwaki, T. Yonekura, Euler number and connectivity indexes of a
//         three dimensional digital picture, Forma 17 (2002)
#pragma once

#include <cstdint>

#include "octavo/core/progress.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

struct EulerNumbers {
  std::int64_t corners = 0;  ///< voxels hang together by corners
  std::int64_t faces = 0;    ///< by faces alone
  double share = 0;          ///< by corners, what lies in the border of the volume weighted

  bool operator==(const EulerNumbers&) const = default;
  EulerNumbers& operator+=(const EulerNumbers& other);
};

/// Uses the threads of the calling task arena.
/// Throws  Error{cancelled}
/// Memory  12 bytes for each voxel of a plane, per thread
EulerNumbers euler_numbers(const MaskTree& mask, Progress& progress);

}  // namespace octavo
