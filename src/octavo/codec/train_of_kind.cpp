#include "octavo/codec/brick_codec.h"
#include "octavo/core/error.h"

namespace octavo {

std::unique_ptr<BrickCodec> train_model(VolumeKind kind, VoxelType type,
                                        std::span<const TrainingBrick> bricks,
                                        const CodecSettings& settings) {
  if (kind == VolumeKind::grey) return train_grey_model(type, bricks, settings);
  if (settings.max_error != 0) {
    throw Error(ErrorKind::invalid_argument, "label maps are always lossless");
  }
  return train_label_model(type, bricks);
}

}  // namespace octavo
