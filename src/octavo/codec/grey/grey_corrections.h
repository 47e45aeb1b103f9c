// Corrections of the few voxels that a quantized brick would leave beyond the maximum error.
//
// A correction is a small whole number per voxel, mostly 0; the voxel moves by that many times the
// model's correction step. Coded voxel by voxel in the order z, y, x with adaptive bits.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/bytes.h"

namespace octavo::grey {

/// A brick that needs a larger correction anywhere is stored instead.
inline constexpr int kMaxCorrection = 31;

/// One number per voxel, dense [z][y][x], each within +-kMaxCorrection.
using Corrections = std::vector<std::int8_t>;

/// Nothing when all are 0.
Bytes encode_corrections(const Corrections& corrections, const Size3& size);

/// Throws Error{corrupt}.
Corrections decode_corrections(ByteSpan bytes, const Size3& size);

}  // namespace octavo::grey
