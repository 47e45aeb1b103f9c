// Volumes moved, turned, scaled, or brought onto another grid.
//
//     step                  what changes                    how
//     translate             the origin                      bricks are copied, not decoded
//     shift                 the place within the grid       whole voxels are moved
//     rotate, mirror        the axes of the grid            whole voxels are moved; where an axis
//                                                           comes to lie between two, values are
//                                                           interpolated
//     scale to a finer grid                                 values are interpolated
//     scale to a coarser    the grid is that of a level     whole voxels are moved
//     affine                the object on its grid          values are interpolated
//     grid of another file                                  values are interpolated
//
// Several steps become one map from the voxels of the last grid to those of the file. So values are
// interpolated once, and only the last grid drops what lies outside of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/core/option_words.h"
#include "octavo/core/volume.h"
#include "octavo/ops/grid/affine.h"
#include "octavo/ops/grid/resample.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(Interpolation) {
  return in_order<Interpolation>("nearest", "linear", "cubic");
}

struct TranslateStep {
  Index3 voxels;
};

struct TranslateMmStep {
  Point3 mm;  ///< LPS
};

/// Voxels moved within the grid.
struct ShiftStep {
  Index3 voxels;
};

/// A rotation about an axis through the center of the grid, right-handed: one about z moves what
/// lies along x towards y. Lengths count in mm.
struct AxisRotation {
  Point3 axis = {0, 0, 1};  ///< along the axes of the grid, of any length but 0
  double degrees = 90;
};

struct RotateStep {
  std::vector<AxisRotation> rotations;
  /// The direction and the center of the grid stay and the object turns; otherwise every voxel
  /// keeps its place in space. Either way the grid becomes as large as the turned volume.
  bool is_in_place = false;
};

struct MirrorStep {
  std::vector<int> axes;
  bool is_in_place = false;
};

/// A grid `factor` times as fine, or the level that is as much coarser, which goes before all steps
/// that move voxels.
struct ScaleStep {
  std::int64_t factor = 2;  ///< a power of two, 2 to 64
  bool is_finer = true;
  bool is_in_place = false;  ///< the grid stays about its center and the object grows or shrinks
};

/// The object moved on its grid: a point p (mm, LPS) goes to map_mm(p).
struct AffineStep {
  Affine map_mm;
  bool is_inverse = false;  ///< map_mm leads from the new place to the old one
};

using TransformStep = std::variant<TranslateStep, TranslateMmStep, ShiftStep, RotateStep,
                                   MirrorStep, ScaleStep, AffineStep>;

/// Adds a step behind others. Rotations that follow one another become one step, so that the grid
/// is made larger once; and so do mirrors.
void add_step(const TransformStep& step, std::vector<TransformStep>& steps);

struct TransformOptions {
  std::string input;  ///< an .8vo file or a URL of one
  Output output;
  std::vector<TransformStep> steps;  ///< one after another
  std::string grid_of;               ///< an .8vo file whose grid is the last one; or empty
  /// Without one nearest for labels, which have no other, and linear for grey values.
  std::optional<Interpolation> interpolation = {};
  /// The real value of voxels from outside; without one 0 for labels and the minimum of a grey
  /// volume.
  std::optional<double> fill = {};
  // Of new voxels; a translation copies those that are there.
  Preset preset = Preset::small;
  double max_error = 0;
};

struct TransformResult {
  VolumeDescription volume;  ///< that of the new file
  std::string operation;     ///< "translate", "rotate, shift", "grid-of", ...
  bool is_copied = false;    ///< the bricks are those of the input
  std::string summary;       ///< what became of the voxels: "voxels shifted within the grid"
  std::uint64_t file_bytes = 0;
};

/// The planes that `transform` writes.
/// Throws  as transform does before it writes, the name of the output apart;
///         Error{invalid_argument} for a translation, which copies bricks
ComputedVolume transformed_planes(const TransformOptions& options, const TaskContext& context);

/// Writes the transformed volume, with a thumbnail if the input has one. Warns where no voxel of
/// the input, or no labeled one, is left in the grid and where an unknown spacing counts.
/// Throws  as open_volume, require_computed, build_file and copy_described;
///         Error{invalid_argument} for steps that the volume does not allow; Error{limit_exceeded}
///         for results that are too large, before any work
/// Memory  that of a build, up to 128 MiB of planes and 32 MiB per thread; of a mask that is turned
///         or shifted two masks
TransformResult transform(const TransformOptions& options, const TaskContext& context);

}  // namespace octavo
