// The grey codec: a trained model and the two procedures that use it.
#pragma once

#include <memory>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/grey/grey_model.h"

namespace octavo::grey {

class GreyCodec final : public BrickCodec {
 public:
  explicit GreyCodec(const Parameters& parameters);

  const Parameters& parameters() const noexcept { return model_->parameters; }

  VolumeKind kind() const noexcept override { return VolumeKind::grey; }
  AxisOrder axis_order() const noexcept override { return model_->parameters.axis_order; }
  bool is_lossless() const noexcept override {
    return model_->parameters.quantizer.is_lossless();
  }
  Bytes serialized() const override { return serialize(model_->parameters); }
  EncodedBrick encode(const BrickShape& shape, const BrickView& brick) const override;
  void decode(const BrickShape& shape, VoxelType type, const ValueRange& range,
              std::span<const ByteSpan> segments, int level, void* out) const override;
  bool decodes_planes() const noexcept override { return true; }
  void decode_box(const BrickShape& shape, VoxelType type, const ValueRange& range,
                  std::span<const ByteSpan> segments, const LevelBox& wanted) const override;
  std::int64_t decode_parent(const BrickShape& shape, VoxelType type, const ValueRange& range,
                             std::span<const ByteSpan> segments) const override;
  bool has_parts(const BrickShape& shape) const noexcept override;
  std::vector<BrickParts::Part> list_parts(const BrickShape& shape,
                                           ByteSpan front) const override;
  std::vector<std::unique_ptr<BrickParts>> open_together(
      VoxelType type, std::span<const CodedBrick> bricks) const override;

 private:
  std::unique_ptr<const Model> model_;
};

}  // namespace octavo::grey
