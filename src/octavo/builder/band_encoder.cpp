#include "octavo/builder/band_encoder.h"

namespace octavo {

void encode_bands(BandReader& bands, const Model& model, TierEncoder& encoder) {
  while (!bands.is_done()) {
    VoxelBlock block = bands.group();
    block.band = &bands.next();
    encoder.finish();
    encoder.start(model, block, true, {});
  }
  encoder.finish();
}

}  // namespace octavo
