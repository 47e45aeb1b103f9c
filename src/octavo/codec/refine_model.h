// Models of later groups of a scan, learned from the first group's.
#pragma once

#include <memory>
#include <span>

#include "octavo/codec/brick_codec.h"

namespace octavo {

/// Trains a model on `bricks` that starts from `first`, the model of the first group of the same
/// scan, trained or parsed: grey models keep its kind and refine its weights, on fewer bricks than
/// training takes. Models of labels are trained as ever.
/// Deterministic: the same first model and bricks give the same model on every machine.
/// settings  those of the first model
/// Throws    Error{invalid_argument} for settings that the kind does not have
std::unique_ptr<BrickCodec> refine_model(const BrickCodec& first, VoxelType type,
                                         std::span<const TrainingBrick> bricks,
                                         const CodecSettings& settings = {});

/// The same of grey models.
std::unique_ptr<BrickCodec> refine_grey_model(const BrickCodec& first, VoxelType type,
                                              std::span<const TrainingBrick> bricks,
                                              const CodecSettings& settings = {});

}  // namespace octavo
