#include "octavo/tasks/components.h"

#include <optional>

#include "octavo/ops/label/component_labels.h"
#include "octavo/tasks/components/component_rows.h"
#include "octavo/tasks/masks.h"

namespace octavo {

namespace {

std::uint64_t write_components(const Components& found, std::size_t kept,
                               const VolumeDescription& volume, const ComponentsOptions& options,
                               const TaskContext& context) {
  LabelTree labels;
  context.on_threads([&] {
    labels = labels_of_components(found, kept, context.max_memory_bytes, &context.watcher());
  });
  return write_label_tree(labels, description_of_components(kept, volume, options),
                          *options.output, "components", context)
      .file_bytes;
}

}  // namespace

ComponentsResult components(const ComponentsOptions& options, const TaskContext& context) {
  if (options.output) require_computed(*options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  require_usable(options, mask.volume());
  std::optional<Components> found;
  context.on_threads([&] {
    found.emplace(mask.tree, options.connectivity, context.max_memory_bytes);
  });

  ComponentsResult result = table_of_components(found->components(), mask.volume(), options,
                                                found->memory_bytes(), context);
  if (options.output) {
    result.file_bytes = write_components(*found, result.kept, result.volume, options, context);
  }
  return result;
}

}  // namespace octavo
