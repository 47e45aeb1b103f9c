// The pose that lays the surface of one mask onto that of another.
#pragma once

#include <string>

#include "octavo/core/volume.h"
#include "octavo/ops/align/pose_agreement.h"
#include "octavo/ops/align/pose_search.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct AlignOptions {
  std::string moving;  ///< a label map; every voxel but 0 is in the mask
  std::string fixed;   ///< another, whose place is taken
  Output matrix;       ///< a text file that read_affine takes; no path: none is written
  bool has_scale = false;
};

/// Shares of agreement below which there is no pose. Half of a surface may be missing, and of what
/// is left voxels twice as large lose a part; around what agrees, most of the other has to.
inline constexpr PoseAgreement kMinimumAgreement = {0.3, 0.6};

struct AlignResult {
  FoundPose pose;  ///< from world space of `moving` to that of `fixed`, mm, LPS
  PoseAgreement agreement;
  bool is_found = false;
  int level = 0;   ///< of the fixed mask that distances were measured at
  double voxel_mm = 0;  ///< of that level
  std::uint64_t points = 0;
};

/// Finds the pose, and writes its matrix where enough of the surfaces agree; otherwise nothing.
/// Of masks larger than 2^26 voxels coarser levels are taken.
/// Throws  as open_labels and PendingFile; Error{invalid_argument} for a mask without a surface and
///         for one of unknown spacing; Error{limit_exceeded}
/// Memory  the masks, 9 bytes for each voxel of the level of the fixed one, 8 of the moving one
AlignResult align(const AlignOptions& options, const TaskContext& context);

}  // namespace octavo
