// The decoding half of the grey codec: segments to voxels, whole bricks or parts of level 0.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/grey/grey_model.h"

namespace octavo::grey {

/// As BrickCodec::decode_box. Throws Error{corrupt, unsupported_version}.
void decode_brick(const Model& model, const BrickShape& shape, VoxelType type,
                  const ValueRange& range, std::span<const ByteSpan> segments,
                  const LevelBox& wanted);

/// As BrickCodec::decode_parent. Throws Error{corrupt, unsupported_version}.
std::int64_t decode_parent(const Model& model, const BrickShape& shape, VoxelType type,
                           const ValueRange& range, std::span<const ByteSpan> segments);

/// As BrickCodec::open_together; the model outlives the result.
/// Throws Error{corrupt, unsupported_version}.
std::vector<std::unique_ptr<BrickParts>> open_parts(const Model& model, VoxelType type,
                                                    std::span<const CodedBrick> bricks);

}  // namespace octavo::grey
