// Whether what a worker reads is what was planned.
#pragma once

#include "octavo/builder/tier_encoder.h"
#include "octavo/builder/voxel_block.h"
#include "octavo/core/volume.h"
#include "octavo/dist/build_plan.h"

namespace octavo {

/// Throws Error{source_rejected} where a source describes itself otherwise than the planned one.
void require_planned(const BuildPlan& plan, const VolumeDescription& source);

/// Throws  Error{source_rejected} where the first group has other voxels than the planned one;
///         Error{invalid_argument} where another program planned, by the model trained on it
void require_first_voxels(const BuildPlan& plan, const VoxelBlock& group, const Model& model);

}  // namespace octavo
