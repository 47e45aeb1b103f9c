// The models of groups, one after the other: what the first group decides holds for all.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "octavo/builder/tier_encoder.h"
#include "octavo/builder/voxel_block.h"
#include "octavo/builder/workers.h"
#include "octavo/codec/brick_codec.h"
#include "octavo/core/levels.h"
#include "octavo/core/volume.h"

namespace octavo {

class GroupTrainer {
 public:
  /// All but `settings` must outlive the trainer.
  GroupTrainer(const VolumeDescription& description, const Levels& levels, Workers& workers,
               const CodecSettings& settings)
      : description_(description), levels_(levels), workers_(workers), settings_(settings) {}

  /// Takes the first group's model as its file holds it; its bytes are proven by whoever has them.
  /// Throws Error{corrupt, unsupported_version}
  void begin_with(ByteSpan first_model);

  /// The model of a group. Without a first one it becomes that.
  const Model& train(const VoxelBlock& group);
  /// The same by the bricks that training chooses of it.
  const Model& train(std::span<const TrainingBrick> chosen, VoxelType type);

  /// Requires train or begin_with.
  const Model& first() const { return *first_; }
  /// Those asked for, with the axis order of the last group.
  const CodecSettings& settings() const { return settings_; }

 private:
  const Model& take(const std::function<std::unique_ptr<BrickCodec>(const BrickCodec*)>& train);

  const VolumeDescription& description_;
  const Levels& levels_;
  Workers& workers_;
  CodecSettings settings_;
  Model model_;
  std::optional<Model> first_;
};

}  // namespace octavo
