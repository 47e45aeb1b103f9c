// Masks moved by whole voxels, rotated by quarter turns and mirrored, on their words alone.
//
// A turn permutes the 64 children of every cube and the 64 voxels of every word alike, so it is one
// permutation of bits applied everywhere. A shift takes every word from up to eight words of the
// source, joined by shifts of slabs; so does it with the bits of cubes, which tells at once what is
// full and what is empty. Where the shift is a multiple of a cube's side, cubes are copied whole.
//
// A mirrored grid ends where the universe of its tree ends, and is then shifted back to its corner.
//
// Source  thesis 1.2 (translation, rotation)
#pragma once

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/grid/axis_turn.h"

namespace octavo {

/// The mask of the turned grid. Uses the threads of the calling task arena; the result does not
/// depend on their number.
MaskTree turned(const MaskTree& mask, const AxisTurn& turn);

/// The voxels moved by `by` in the same volume; what leaves it is dropped. Uses the threads of the
/// calling task arena; the result does not depend on their number.
MaskTree shifted(const MaskTree& mask, const Index3& by);

}  // namespace octavo
