// What tells programs apart that make other bytes of the same voxels.
//
// A library of other rounding or a compiler that reorders sums may change a byte that a version
// number does not. So small volumes that stand in the program are encoded, and what comes out is
// summed up: programs of one sum make parts of one file.
#pragma once

#include <cstdint>

namespace octavo {

/// CRC-32C of the models, bricks and digests of planes of small volumes: grey in both presets and
/// with a max error, labels, floats exactly and with a max error. Found once, in less than a
/// tenth of a second.
std::uint32_t codec_check();

}  // namespace octavo
