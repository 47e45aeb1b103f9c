// Encodes a group that memory does not hold, band by band.
#pragma once

#include "octavo/builder/band_reader.h"
#include "octavo/builder/tier_encoder.h"

namespace octavo {

/// Encodes the bands that are left of a group and waits for them: while one is being encoded the
/// next one is read. Where it throws, the encoder may still look at `bands`.
/// Throws as BandReader::next and TierEncoder::finish
void encode_bands(BandReader& bands, const Model& model, TierEncoder& encoder);

}  // namespace octavo
