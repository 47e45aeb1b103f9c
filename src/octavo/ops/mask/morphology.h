// Masks grown and shrunk: dilation, erosion, opening and closing by a ball in mm or by steps from
// voxel to neighbor.
//
// A mask grows from its surface. Only cubes of 64^3 voxels that the surface reaches are worked on;
// those inside the mask, those out of reach and those that a single voxel of the surface covers
// whole are settled on the tree. In a cube, every row of 64 voxels is a word: a row of the surface
// is widened by shifts, for each of the rows it reaches by as much as the ball is wide there.
//
//     rows of the cube      . . . 1 1 1 . . .     the ball's run at dy = 1
//                           . . 1 1 1 1 1 . .                       dy = 0, the row of the surface
//                           . . . 1 1 1 . . .                       dy = 1
//
// Time goes with the cubes worked on: for each with the rows of the surface in its reach, and for
// each row with the planes and the rows of the cube that it reaches and that are not full yet, 64
// of each at most. Cubes that are settled cost a search of the surface's tree.
//
// Outside the volume there is background that does not spread: nothing grows in from there and
// nothing is eroded from there. So closing never loses a voxel and opening never adds one.
//
// Source  thesis 1.2; Serra, Image Analysis and Mathematical Morphology, 1982
#pragma once

#include <cstdint>

#include "octavo/core/progress.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/reach.h"

namespace octavo {

/// The voxels that are in the mask or reached from one that is.
/// Uses the threads of the calling task arena; the result does not depend on their number.
/// reach      made for the size of the mask
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when what grows needs more
/// Throws  Error{cancelled}
/// Memory  that of the mask's surface, of what grows in pieces and put together, and of the result;
///         about 170 bytes per cube of 64^3 worked on or covered; dilation_thread_bytes per thread
MaskTree dilate(const MaskTree& mask, const Reach& reach, Progress& progress,
                std::uint64_t max_bytes = 0);

/// The voxels of the mask that reach no voxel of the volume that is not in it.
/// As dilate of the complement
MaskTree erode(const MaskTree& mask, const Reach& reach, Progress& progress,
               std::uint64_t max_bytes = 0);

/// Erosion, then dilation: the places of the mask that the ball fits into. As dilate
MaskTree opening(const MaskTree& mask, const Reach& reach, Progress& progress,
                 std::uint64_t max_bytes = 0);

/// Dilation, then erosion: the mask with the gaps that the ball does not fit into. As dilate
MaskTree closing(const MaskTree& mask, const Reach& reach, Progress& progress,
                 std::uint64_t max_bytes = 0);

/// Bytes that one thread works in, for a mask of `size`.
std::uint64_t dilation_thread_bytes(const Reach& reach, const Size3& size) noexcept;

}  // namespace octavo
