// The codec of label bricks: a LabelModel at work.
#pragma once

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/label/label_model.h"

namespace octavo {

class LabelCodec final : public BrickCodec {
 public:
  LabelCodec(VoxelType type, LabelModel model) : type_(type), model_(std::move(model)) {}

  VolumeKind kind() const noexcept override { return VolumeKind::labels; }
  Bytes serialized() const override { return serialize(model_, type_); }
  EncodedBrick encode(const BrickShape& shape, const BrickView& brick) const override;
  void decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
              std::span<const ByteSpan> segments, int level, void* out) const override;

 private:
  VoxelType type_;
  LabelModel model_;
};

}  // namespace octavo
