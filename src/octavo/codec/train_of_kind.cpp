#include "octavo/codec/brick_codec.h"

namespace octavo {

std::unique_ptr<BrickCodec> train_model(VolumeKind kind, VoxelType type,
                                        std::span<const TrainingBrick> bricks) {
  return kind == VolumeKind::labels ? train_label_model(type, bricks)
                                    : train_grey_model(type, bricks);
}

}  // namespace octavo
