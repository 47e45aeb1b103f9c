// The leaves of a mask that are not hidden among others.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/volume.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct ShellOptions {
  std::string input;             ///< a label map; every voxel but 0 is in the mask
  std::optional<Output> output;  ///< nothing: leaves are counted only
};

struct ShellResult {
  VolumeDescription volume;  ///< that of the mask
  std::int64_t leaves = 0;   ///< of the mask
  std::int64_t kept = 0;     ///< of its shell
  std::uint64_t voxels = 0;  ///< of its shell
  std::uint64_t file_bytes = 0;  ///< 0 where no file is written
};

/// Keeps the leaves that leaves of their size or larger do not cover on all six sides.
/// Throws  as require_computed, open_mask and build_file
/// Memory  three masks
ShellResult shell(const ShellOptions& options, const TaskContext& context);

}  // namespace octavo
