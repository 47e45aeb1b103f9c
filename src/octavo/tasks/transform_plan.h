// What a transform does: the new grid, and where its voxels come from.
#pragma once

#include <optional>
#include <string>

#include "octavo/core/metadata.h"
#include "octavo/file/reader.h"
#include "octavo/ops/grid/axis_turn.h"
#include "octavo/tasks/transform.h"

namespace octavo {

/// Each way can do what those before it can.
enum class TransformWay {
  copy,      ///< only the geometry changes
  move,      ///< whole voxels
  resample,  ///< values between voxels
};

struct TransformPlan {
  TransformWay way = TransformWay::copy;
  std::string operation;  ///< the names of the steps
  std::string summary;    ///< what becomes of the voxels
  MadeBy made_by{"transform"};
  int level = 0;
  bool is_scaled = false;
  Size3 size;
  Geometry geometry;
  Affine to_source;  ///< from voxels of the grid to those of the level
  // Of whole voxels: a turn, and then a shift within the turned grid.
  AxisTurn turn;
  Index3 shift;
  Interpolation interpolation = Interpolation::nearest;
  double outside = 0;  ///< the stored value of voxels that come from outside
  /// The metadata of another file's grid, which say where its spacing is from.
  std::optional<Metadata> spacing_from;
  bool is_apart = false;   ///< no voxel of the input is left in the grid
  bool is_placed = false;  ///< the grid is known to lie in a body, whatever is known of the input
};

/// The plan of all steps. Warns where no voxel of the input is left in the grid and where an
/// unknown spacing counts.
/// Throws Error{invalid_argument} for steps that the volume does not allow; what open_volume throws
TransformPlan plan_transform(const TransformOptions& options, const FileReader& reader,
                             const TaskContext& context);

}  // namespace octavo
