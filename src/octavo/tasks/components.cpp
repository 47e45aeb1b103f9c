#include "octavo/tasks/components.h"

#include <algorithm>

#include "octavo/core/error.h"
#include "octavo/core/size_tolerance.h"
#include "octavo/ops/label/component_labels.h"
#include "octavo/ops/mask/components.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// How many components, the largest first, are kept.
std::size_t kept_count(const Components& found, const ComponentsOptions& options,
                       const VolumeDescription& volume) {
  const auto& all = found.components();
  const auto mm3 = voxel_mm3(volume);
  const auto end = std::find_if(all.begin(), all.end(), [&](const Component& component) {
    return mm3 && static_cast<double>(component.voxel_count) * *mm3 < lower_limit(options.min_mm3);
  });
  const auto large = static_cast<std::size_t>(end - all.begin());
  if (options.keep_largest == 0) return large;
  return std::min(large, static_cast<std::size_t>(options.keep_largest));
}

std::vector<ComponentRow> rows_of(const Components& found, std::size_t count,
                                  const VolumeDescription& volume) {
  std::vector<ComponentRow> rows;
  rows.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Component& component = found.components()[i];
    ComponentRow& row = rows.emplace_back();
    row.label = static_cast<std::int64_t>(i + 1);
    row.voxels = component.voxel_count;
    row.mm3 = mm3_of(component.voxel_count, volume);
    row.centroid = component.centroid;
    if (row.mm3) row.centroid_mm = volume.geometry.to_world(component.centroid);
    row.box = component.box;
  }
  return rows;
}

VoxelType label_type(std::size_t count) {
  return count <= 0xff ? VoxelType::uint8 : count <= 0xffff ? VoxelType::uint16 : VoxelType::uint32;
}

MadeBy made_by(const ComponentsOptions& options) {
  MadeBy made("components");
  made.set("connectivity", static_cast<int>(options.connectivity));
  if (options.keep_largest > 0) made.set("keep_largest", options.keep_largest);
  if (options.min_mm3 > 0) made.set("min_mm3", options.min_mm3);
  return made;
}

std::uint64_t write_components(const Components& found, std::size_t kept,
                               const VolumeDescription& volume, const ComponentsOptions& options,
                               const TaskContext& context) {
  LabelTree labels;
  context.on_threads([&] {
    labels = labels_of_components(found, kept, context.max_memory_bytes, &context.watcher());
  });
  return write_label_tree(labels, label_description(volume, label_type(kept), made_by(options)),
                          *options.output, "components", context)
      .file_bytes;
}

}  // namespace

ComponentsResult components(const ComponentsOptions& options, const TaskContext& context) {
  if (options.output) require_computed(*options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  if (options.min_mm3 > 0) require_known_spacing(mask.volume(), options.input, "a volume in mm3");
  std::optional<Components> found;
  context.on_threads([&] {
    found.emplace(mask.tree, options.connectivity, context.max_memory_bytes);
  });

  ComponentsResult result{.volume = mask.volume(), .found = found->components().size()};
  result.kept = kept_count(*found, options, result.volume);
  const std::size_t rows = std::min(result.kept, options.max_rows);
  context.require_memory(
      found->memory_bytes() + rows * (sizeof(ComponentRow) + options.bytes_per_row),
      "the table of components");
  result.rows = rows_of(*found, rows, result.volume);
  if (options.output) {
    result.file_bytes = write_components(*found, result.kept, result.volume, options, context);
  }
  return result;
}

}  // namespace octavo
