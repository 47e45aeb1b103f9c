#include "octavo/tasks/files/exported_voxels.h"

#include "octavo/core/sha256.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

void compare_with_export(const PlaneSource& source, const BuildOptions& options,
                         const BuildResult& built, const std::string& name,
                         const std::string& path, const TaskContext& context) {
  const std::string& exported = source.files().voxels_sha256;
  const bool is_changed = built.max_error > 0 || built.detail_errors || options.repair.nan ||
                          options.repair.infinity;
  if (exported.empty() || is_changed) return;
  if (hex_text(open_volume(path, context)->voxel_digest()) == exported) return;
  context.warn(name + ": its voxels are not those that were exported (voxels_sha256): chunks were "
                      "changed since, are missing, or are damaged");
}

}  // namespace octavo
