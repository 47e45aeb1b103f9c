// Holes of a mask: parts of the background that do not reach the border of the volume.
//
// The background is the complement, and its parts are found on its tree. Object and background take
// dual connectivities, so that a closed surface of the object separates inside from outside and an
// open one does not: an object joined by faces lets the background through its edges and corners;
// one joined by edges or corners does not.
//
//     object       6    18   26
//     background   26    6    6
//
// Source  thesis 1.2; dual connectivity: Kong, Rosenfeld, Digital topology: introduction and
//         survey, 1989
#pragma once

#include <cstdint>
#include <limits>

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo {

/// How voxels of the background are connected when those of the object are so.
constexpr Connectivity dual_of(Connectivity object) noexcept {
  return object == Connectivity::faces ? Connectivity::corners : Connectivity::faces;
}

struct FilledHoles {
  MaskTree mask;
  std::uint64_t hole_count = 0;   ///< that were filled
  std::uint64_t voxel_count = 0;  ///< in them
  std::uint64_t kept_count = 0;   ///< holes that were left because they are larger than asked for
};

/// The mask with its holes. Uses the threads of the calling task arena; the result does not depend
/// on their number.
/// object      how voxels of the mask are connected
/// max_voxels  larger holes are left
/// max_bytes   as Components takes it
/// Throws  Error{limit_exceeded} as Components does
/// Memory  that of the components of the complement, about three times the mask
FilledHoles fill_holes(const MaskTree& mask, Connectivity object,
                       std::uint64_t max_voxels = std::numeric_limits<std::uint64_t>::max(),
                       std::uint64_t max_bytes = 0);

}  // namespace octavo
