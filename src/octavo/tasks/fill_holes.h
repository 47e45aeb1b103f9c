// Background that is enclosed by a mask becomes part of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/made_by.h"
#include "octavo/core/volume.h"
#include "octavo/ops/mask/fill_holes.h"
#include "octavo/ops/mask/word_neighbors.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct FillHolesOptions {
  std::string input;  ///< a label map; every voxel but 0 is in the mask
  Output output;
  /// That of the object; the background takes the dual one (ops/mask/fill_holes.h).
  Connectivity connectivity = Connectivity::corners;
  std::optional<double> max_mm3{};  ///< larger holes are left
};

struct FillHolesResult {
  VolumeDescription volume;  ///< that of the mask
  std::uint64_t voxels = 0;  ///< of the filled mask
  std::uint64_t hole_count = 0;  ///< that were filled
  std::uint64_t hole_voxels = 0;
  std::uint64_t larger_hole_count = 0;  ///< that were left
  std::uint64_t file_bytes = 0;
};

/// A mask with its holes filled, in memory.
struct FilledMask {
  FilledHoles filled;
  MadeBy made_by;
};

/// The mask that fill_holes writes.
/// volume   that the mask is of
/// options  their input names the mask in errors
/// Throws  as fill_holes does before it writes, opening apart
FilledMask filled_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const FillHolesOptions& options, const TaskContext& context);

/// Writes the mask with its holes filled.
/// Throws  as require_computed, open_mask, fill_holes of masks and build_file;
///         Error{invalid_argument} for a largest volume where the spacing is not known
/// Memory  six masks
FillHolesResult fill_holes(const FillHolesOptions& options, const TaskContext& context);

}  // namespace octavo
