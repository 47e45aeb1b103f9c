// Counts of clipped floats as bytes, with which they travel from parts and ranks to the whole.
#pragma once

#include "octavo/builder/exact_coding.h"
#include "octavo/core/bytes.h"

namespace octavo {

Bytes clipped_bytes(const ClippedVoxels& clipped);

/// Takes what clipped_bytes wrote from the front of `bytes`.
/// what  they are part of, for errors
/// Throws Error{corrupt}
ClippedVoxels take_clipped(ByteSpan& bytes, const char* what);

}  // namespace octavo
