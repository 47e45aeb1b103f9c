// What tells programs apart that make other bytes of the same voxels.
//
// A library of other rounding or a compiler that reorders sums may change a byte that a version
// number does not. So a small volume that stands in the program is encoded as the planned one is,
// and what comes out is summed up: programs of one sum make parts of one file.
#pragma once

#include <cstdint>

#include "octavo/builder/builder.h"
#include "octavo/core/voxel_type.h"

namespace octavo {

/// CRC-32C of the model, bricks and digests of planes of a small volume: of labels, or of integers
/// or floats, exactly or with a max error, in the preset of the build. Found once for each of
/// these, in some 10 ms. Thread-safe.
/// type  of the source
std::uint32_t codec_check(VoxelType type, const BuildOptions& options);

}  // namespace octavo
