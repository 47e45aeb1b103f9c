// Which bricks of a group a model is trained on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octavo/builder/voxel_block.h"

namespace octavo {

inline constexpr std::size_t kTrainingBricks = 32;

/// Which of the bricks that are not uniform a model is trained on, by their places among these: at
/// most 32, spread evenly and, while enough others remain, no slivers at the border.
/// voxel_counts       of the bricks, in file order
/// full_voxel_count   of a brick that no border cuts off
std::vector<std::size_t> training_choice(std::span<const std::int64_t> voxel_counts,
                                         std::int64_t full_voxel_count);

/// Trains a model on bricks that were chosen, as train_on does.
std::unique_ptr<BrickCodec> train_on_choice(std::span<const TrainingBrick> chosen, VoxelType type,
                                            VolumeKind kind, const CodecSettings& settings,
                                            const std::optional<SampleCoding>& coding,
                                            const BrickCodec* first);

/// The bricks of a block that a model for it is trained on.
std::vector<TrainingBrick> training_bricks_of(const Levels& levels, int tier,
                                              const VoxelBlock& block);

/// Trains a model for the bricks of a block on a choice of them. Depends on the voxels and the
/// first model alone.
/// coding  that of the block's voxels where these are float32
/// first   the model of the first group, trained or parsed, or null for that group itself
std::unique_ptr<BrickCodec> train_on(const Levels& levels, int tier, const VoxelBlock& block,
                                     VolumeKind kind, const CodecSettings& settings,
                                     const std::optional<SampleCoding>& coding = std::nullopt,
                                     const BrickCodec* first = nullptr);

}  // namespace octavo
