#include "octavo/tasks/files/exported_voxels.h"

#include "octavo/core/sha256.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

void compare_with_export(const std::string& exported, const FloatRepair& repair,
                         const BuildResult& built, const std::string& name,
                         const std::string& path, const TaskContext& context) {
  const bool is_changed =
      built.max_error > 0 || built.detail_errors || repair.nan || repair.infinity;
  if (exported.empty() || is_changed) return;
  if (hex_text(open_volume(path, context)->voxel_digest()) == exported) return;
  context.warn(name + ": its voxels are not those that were exported (voxels_sha256): chunks were "
                      "changed since, are missing, or are damaged");
}

}  // namespace octavo
