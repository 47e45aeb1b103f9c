// Whether a scan that comes back from an export has the voxels that left.
#pragma once

#include <string>

#include "octavo/builder/builder.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Warns where a file that was built without loss has other voxels than its source says that were
/// exported: chunks that are missing are no damage to zarr.
/// exported  the voxels_sha256 that the source says; empty where it says none
/// repair    of its values on their way
/// name      of the source
/// path      of the file that was built
/// Throws    as open_volume
void compare_with_export(const std::string& exported, const FloatRepair& repair,
                         const BuildResult& built, const std::string& name,
                         const std::string& path, const TaskContext& context);

}  // namespace octavo
