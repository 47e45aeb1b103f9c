// The value, the place and the o-code of single voxels.
#pragma once

#include <string>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/octree/o_code.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct ProbeOptions {
  std::string input;  ///< an .8vo file or a URL of one
  int level = 0;
  std::vector<Index3> indices;      ///< in samples of the level
  std::vector<Point3> positions_mm;  ///< in world space; the nearest sample answers
};

struct ProbedVoxel {
  Index3 index;
  Point3 world_mm{};
  double stored = 0;
  OCode code;
  int root_level = 0;
  BrickEntry brick;  ///< that holds it
};

struct ProbeResult {
  VolumeDescription volume;
  std::vector<ProbedVoxel> voxels;  ///< those of the indices first
};

/// Throws  as open_volume; Error{invalid_argument} for a level that is not there, places outside
///         the volume, places in mm where the spacing is not known; what reading throws
ProbeResult probe(const ProbeOptions& options, const TaskContext& context);

}  // namespace octavo
