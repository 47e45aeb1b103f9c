// The voxels at the surface of a mask.
#pragma once

#include "octavo/core/progress.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// The voxels of a mask with a face neighbor that is not in it, or outside the volume. Uses the
/// threads of the calling task arena; the result does not depend on their number.
/// watcher  its is_cancelled() ends the work with Error{cancelled}; nothing is reported to it
/// Memory  that of the result twice, and 700 bytes per cube of 64^3 at the surface
MaskTree surface_voxels(const MaskTree& mask, const Progress& watcher);

}  // namespace octavo
