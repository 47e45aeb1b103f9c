// The codec of label bricks: a LabelModel at work.
#pragma once

#include "octavo/codec/label/label_model.h"
#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label_bricks.h"

namespace octavo {

class LabelCodec final : public LabelBrickCodec {
 public:
  LabelCodec(VoxelType type, LabelModel model) : type_(type), model_(std::move(model)) {}

  VolumeKind kind() const noexcept override { return VolumeKind::labels; }
  Bytes serialized() const override { return serialize(model_, type_); }
  EncodedBrick encode(const BrickShape& shape, const BrickView& brick) const override;
  void decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
              std::span<const ByteSpan> segments, int level, void* out) const override;
  std::int64_t decode_parent(const BrickShape& shape, VoxelType type, const ValueRange& range,
                             std::span<const ByteSpan> segments) const override;
  EncodedBrick encode_words(const BrickShape& shape, const LabelWords& words) const override;
  void decode_words(const BrickShape& shape, const ValueRange& range,
                    std::span<const ByteSpan> segments, LabelWords& words) const override;

 private:
  /// complete  fills in what the pyramid lacks of level 0
  template <class Complete>
  EncodedBrick encode_pyramid(const BrickShape& shape, LabelPyramid& pyramid,
                              Complete complete) const;

  VoxelType type_;
  LabelModel model_;
};

}  // namespace octavo
