// The region octree of a grey volume, its cubes evened out to their means.
#pragma once

#include <string>

#include "octavo/tasks/build_planes.h"

namespace octavo {

struct CondenseVolumeOptions {
  std::string input;  ///< an .8vo file or a URL of one
  Output output;
  double flat = 0;  ///< the most by which the voxels of a cube may differ, real units
};

/// The planes that condense_volume writes.
/// Throws  as condense_volume does before it writes, the name of the output apart
ComputedVolume condensed_planes(const CondenseVolumeOptions& options, const TaskContext& context);

/// Writes a grey volume whose cubes that hardly vary hold their means. Means of float32 voxels are
/// numbers that the bricks of the input can hold, and differences count up to rounding.
/// Throws  as open_volume, require_computed, make_flat_cubes and build_file;
///         Error{invalid_argument} for labels and a negative `flat`
BuiltVolume condense_volume(const CondenseVolumeOptions& options, const TaskContext& context);

}  // namespace octavo
