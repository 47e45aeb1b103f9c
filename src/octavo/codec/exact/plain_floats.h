// Bricks that coding would enlarge: their floats stand as they are, 4 bytes each.
//
// Codes follow from the floats, those of absent voxels as fill_absent makes them; coarser levels
// are means of these.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/codec/exact/float_codes.h"
#include "octavo/core/bytes.h"
#include "octavo/core/volume.h"

namespace octavo::exact {

Bytes encode_plain_floats(std::span<const float> voxels);

/// codes   bounds of the codes of finite voxels
/// Throws  Error{corrupt} when the bytes are not those of `voxels`, or a finite one lies outside
void decode_plain_floats(ByteSpan bytes, const FloatBins& bins, const ValueRange& codes,
                         std::span<float> voxels);

/// The samples of a level as codes.
struct CodedLevel {
  std::vector<std::int32_t> codes;  ///< dense [z][y][x]
  AbsentFlags absent;               ///< empty: none is
};

/// In-brick level `level` of voxels that were quantized, or the sample above them at the level
/// behind the last.
CodedLevel level_of(const QuantizedBrick& brick, const BrickShape& shape, int level,
                    const AxisOrder& order);

}  // namespace octavo::exact
