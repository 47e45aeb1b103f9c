// Which float of its bin a voxel is.
//
// Away from zero the ranks of a bin are as likely as each other, so the place is plain bits. The
// bin around zero spans many exponents: there zeros, signs and exponents are coded adaptively and
// the mantissa is plain. Mantissa bits that are 0 in a whole box are not coded at all.
// Where floats come again and again a voxel may be said to be the last one of the same code.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/codec/exact/absent_samples.h"
#include "octavo/codec/exact/float_bins.h"
#include "octavo/core/box.h"
#include "octavo/core/bytes.h"

namespace octavo::exact {

/// The voxels of a box, dense [z][y][x].
/// absent  empty: none is; voxels that are have no place
struct PlaceBox {
  Size3 size;
  std::span<const std::int32_t> codes;
  std::span<const std::uint8_t> absent;
};

/// Requires of every voxel that is present that its code is that of its bin.
Bytes encode_places(const FloatBins& bins, const PlaceBox& box, std::span<const float> voxels);

/// Takes the places off the front of `segment`; writes the voxels that are present.
/// Throws  Error{corrupt, unsupported_version}
void decode_places(const FloatBins& bins, const PlaceBox& box, ByteSpan& segment,
                   std::span<float> voxels);

/// Takes the places off the front of `segment` unread. Throws as decode_places.
void skip_places(ByteSpan& segment);

}  // namespace octavo::exact
