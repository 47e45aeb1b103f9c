// Which bricks of a group a model is trained on.
#pragma once

#include <memory>

#include "octavo/builder/voxel_block.h"

namespace octavo {

inline constexpr std::size_t kTrainingBricks = 32;

/// Trains a model for the bricks of a block on at most 32 of them, spread evenly in file order:
/// those that are not uniform and, while enough others remain, not slivers at the border.
/// Depends on the voxels alone.
std::unique_ptr<BrickCodec> train_on(const Levels& levels, int tier, const VoxelBlock& block,
                                     VolumeKind kind, const CodecSettings& settings);

}  // namespace octavo
