#include "octavo/codec/brick_codec.h"

namespace octavo {

std::unique_ptr<BrickCodec> parse_model(VolumeKind kind, VoxelType type, ByteSpan bytes) {
  return kind == VolumeKind::labels ? parse_label_model(type, bytes)
                                    : parse_grey_model(type, bytes);
}

}  // namespace octavo
