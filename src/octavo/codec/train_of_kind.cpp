#include "octavo/codec/brick_codec.h"
#include "octavo/codec/refine_model.h"
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

std::unique_ptr<BrickCodec> refine_model(const BrickCodec& first, VoxelType type,
                                         std::span<const TrainingBrick> bricks,
                                         const CodecSettings& settings) {
  if (first.kind() == VolumeKind::grey) return refine_grey_model(first, type, bricks, settings);
  return train_model(first.kind(), type, bricks, settings);
}

}  // namespace octavo
