#include "octavo/tasks/fill_holes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "octavo/core/size_tolerance.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// The largest hole that is filled, in voxels.
std::uint64_t max_voxels(const FillHolesOptions& options, const VolumeDescription& volume) {
  if (!options.max_mm3) return std::numeric_limits<std::uint64_t>::max();
  require_known_spacing(volume, options.input, "a volume in mm3");
  const double voxels = upper_limit(*options.max_mm3) / *voxel_mm3(volume);
  return static_cast<std::uint64_t>(std::clamp(std::floor(voxels), 0.0, 1e18));
}

MadeBy made_by(const FillHolesOptions& options) {
  MadeBy made("fill-holes");
  made.set("connectivity", static_cast<int>(options.connectivity));
  if (options.max_mm3) made.set("max_mm3", *options.max_mm3);
  return made;
}

}  // namespace

FilledMask filled_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const FillHolesOptions& options, const TaskContext& context) {
  const std::uint64_t largest = max_voxels(options, volume);
  // The complement, its components, those selected and the result.
  context.require_memory(6 * mask.memory_bytes(), "the holes");
  FilledMask made{.filled = {.mask = MaskTree()}, .made_by = made_by(options)};
  context.on_threads([&] {
    made.filled = fill_holes(mask, options.connectivity, largest, context.max_memory_bytes);
  });
  return made;
}

FillHolesResult fill_holes(const FillHolesOptions& options, const TaskContext& context) {
  require_computed(options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  const VolumeDescription& volume = mask.volume();
  const auto [filled, made_by] = filled_mask(mask.tree, volume, options, context);
  const BuildResult built =
      write_mask(filled.mask, volume, made_by, options.output, "fill-holes", context);
  return {.volume = volume,
          .voxels = filled.mask.voxel_count(),
          .hole_count = filled.hole_count,
          .hole_voxels = filled.voxel_count,
          .larger_hole_count = filled.kept_count,
          .file_bytes = built.file_bytes};
}

}  // namespace octavo
