// Whether a volume is known to lie in a body.
#pragma once

#include "octavo/core/volume.h"

namespace octavo {

/// False when nothing places the volume in a body, so that origin and direction say nothing of a
/// patient: the metadata say so, or it lies at the origin along the axes, as stacks of plain
/// pictures do.
bool is_place_known(const VolumeDescription& description);

}  // namespace octavo
