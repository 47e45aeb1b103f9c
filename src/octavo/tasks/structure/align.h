// The pose that lays a surface onto that of a mask: another mask, a mesh, points, or the lines of
// sight that contours of X-ray pictures are.
#pragma once

#include <string>

#include "octavo/core/volume.h"
#include "octavo/ops/align/pose_agreement.h"
#include "octavo/ops/align/pose_search.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/result_facts.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct AlignOptions {
  std::string moving;  ///< as moving_surface.h says
  std::string fixed;   ///< a label map whose place is taken; every voxel but 0 is in the mask
  Output matrix;       ///< a text file that read_affine takes; no path: none is written
  bool has_scale = false;
  Output picture = {};  ///< a PNG of both; no path: none is written
};

/// Agreement below which there is no pose. Half of a surface may be missing, and of what is left
/// voxels twice as large lose a part; around what agrees, most of the other has to. Sharpness and
/// parting lie between what was measured of poses that were right and of such that were not:
/// docs/poses.md has both.
inline constexpr PoseAgreement kMinimumAgreement = {0.3, 0.6, 0.75, 0.85};
/// The sharpness below which a pose is doubtful: bodies that are much alike reach it.
inline constexpr double kClearSharpness = 0.85;
/// What has to agree around of the second where sharpness is clear: small bodies of few voxels lose
/// more of it at a cut.
inline constexpr double kClearBackward = 0.5;
/// What has to agree around of the second where each has parts that the other lacks, and sharpness
/// has to be clear: two parts of bodies can be laid onto each other in many ways.
inline constexpr double kBothAloneBackward = 0.75;
/// How much less sharp meshes and points may be: those on a cut have no sides that tell them from
/// others.
inline constexpr double kPointBlur = 0.1;

/// The share of lines of sight that have to touch the surface within a voxel; nothing is asked of
/// the other way, nor of sharpness, since pixels of pictures may be coarser than voxels.
inline constexpr double kMinimumSights = 0.8;
/// The share of them below which a pose is doubtful.
inline constexpr double kClearSights = 0.9;

struct AlignResult {
  FoundPose pose;  ///< from world space of `moving` to that of `fixed`, mm, LPS
  PoseAgreement agreement;
  bool is_found = false;
  bool is_doubtful = false;  ///< found, but fewer agree than of the same surface do
  std::string why_none;      ///< in words, where none is found
  int level = 0;   ///< of the fixed mask that distances were measured at
  double voxel_mm = 0;  ///< of that level
  std::uint64_t points = 0;
  bool has_lines = false;  ///< what moved were lines of sight: points counts these
  bool has_sides = false;  ///< it was a mask
};

/// Finds the pose, and writes its matrix and picture where enough of the surfaces agree; otherwise
/// nothing. Warns of one that is doubtful. Lines of sight are moved as the rest is: the inverse of
/// their pose takes the mask to where the pictures were taken. Of masks larger than 2^26 voxels
/// coarser levels are taken.
/// Throws  as open_labels, read_features, require_png and PendingFile; Error{invalid_argument} for
///         a mask without a surface, for one of unknown spacing and for a matrix that is named as
///         a volume; Error{limit_exceeded}
/// Memory  the masks, 9 bytes for each voxel of their levels
AlignResult align(const AlignOptions& options, const TaskContext& context);

/// What was found, by name. The matrix is the rows of one of 4 x 4 without the last, from mm to mm,
/// LPS; nothing where there is no pose.
Facts pose_facts(const AlignResult& result);

}  // namespace octavo
