#include "octavo/tasks/shell.h"

#include "octavo/ops/mask/shell.h"
#include "octavo/tasks/masks.h"

namespace octavo {

ShellResult shell(const ShellOptions& options, const TaskContext& context) {
  if (options.output) require_computed(*options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  context.require_memory(3 * mask.tree.memory_bytes(), "the mask and its shell");
  MaskTree made;
  context.on_threads([&] { made = shell(mask.tree); });
  ShellResult result{.volume = mask.volume(),
                     .leaves = leaf_count(mask.tree),
                     .kept = leaf_count(made),
                     .voxels = made.voxel_count()};
  if (options.output) {
    result.file_bytes = write_mask(made, result.volume, MadeBy("shell"), *options.output,
                                   "shell", context)
                            .file_bytes;
  }
  return result;
}

}  // namespace octavo
