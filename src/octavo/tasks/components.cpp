#include "octavo/tasks/components.h"

#include <optional>

#include "octavo/ops/label/component_labels.h"
#include "octavo/tasks/components/component_rows.h"
#include "octavo/tasks/masks.h"

namespace octavo {

namespace {

LabelTree kept_labels(const Components& found, std::size_t kept, const TaskContext& context) {
  LabelTree labels;
  context.on_threads([&] {
    labels = labels_of_components(found, kept, context.max_memory_bytes, &context.watcher());
  });
  return labels;
}

Components found_components(const MaskTree& mask, const ComponentsOptions& options,
                            const TaskContext& context) {
  std::optional<Components> found;
  context.on_threads(
      [&] { found.emplace(mask, options.connectivity, context.max_memory_bytes); });
  return std::move(*found);
}

}  // namespace

LabeledMask labeled_components(const MaskTree& mask, const VolumeDescription& volume,
                               const ComponentsOptions& options, const TaskContext& context) {
  require_usable(options, volume);
  const Components found = found_components(mask, options, context);
  LabeledMask made;
  made.table =
      table_of_components(found.components(), volume, options, found.memory_bytes(), context);
  made.labels = kept_labels(found, made.table.kept, context);
  made.volume = description_of_components(made.table.kept, volume, options);
  return made;
}

ComponentsResult components(const ComponentsOptions& options, const TaskContext& context) {
  if (options.output) require_computed(*options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  require_usable(options, mask.volume());
  const Components found = found_components(mask.tree, options, context);
  ComponentsResult result = table_of_components(found.components(), mask.volume(), options,
                                                found.memory_bytes(), context);
  if (!options.output) return result;
  result.file_bytes =
      write_label_tree(kept_labels(found, result.kept, context),
                       description_of_components(result.kept, result.volume, options),
                       *options.output, "components", context)
          .file_bytes;
  return result;
}

}  // namespace octavo
