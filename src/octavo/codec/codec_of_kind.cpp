#include "octavo/codec/brick_codec.h"

namespace octavo {

std::unique_ptr<BrickCodec> parse_model(VolumeKind kind, VoxelType type, ByteSpan bytes,
                                        int detail_level) {
  return kind == VolumeKind::labels ? parse_label_model(type, bytes)
                                    : parse_grey_model(type, bytes, detail_level);
}

}  // namespace octavo
