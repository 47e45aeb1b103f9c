#include "octavo/tasks/components/component_rows.h"

#include <algorithm>

#include "octavo/core/size_tolerance.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// How many components, the largest first, are kept.
std::size_t kept_count(std::span<const Component> all, const ComponentsOptions& options,
                       const VolumeDescription& volume) {
  const auto mm3 = voxel_mm3(volume);
  const auto end = std::find_if(all.begin(), all.end(), [&](const Component& component) {
    return mm3 && static_cast<double>(component.voxel_count) * *mm3 < lower_limit(options.min_mm3);
  });
  const auto large = static_cast<std::size_t>(end - all.begin());
  if (options.keep_largest == 0) return large;
  return std::min(large, static_cast<std::size_t>(options.keep_largest));
}

std::vector<ComponentRow> rows_of(std::span<const Component> all,
                                  const VolumeDescription& volume) {
  std::vector<ComponentRow> rows;
  rows.reserve(all.size());
  for (const Component& component : all) {
    ComponentRow& row = rows.emplace_back();
    row.label = static_cast<std::int64_t>(rows.size());
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

}  // namespace

ComponentsResult table_of_components(std::span<const Component> all,
                                     const VolumeDescription& volume,
                                     const ComponentsOptions& options, std::uint64_t held_bytes,
                                     const TaskContext& context) {
  ComponentsResult result{.volume = volume, .found = all.size()};
  result.kept = kept_count(all, options, volume);
  const std::size_t rows = std::min(result.kept, options.max_rows);
  context.require_memory(held_bytes + rows * (sizeof(ComponentRow) + options.bytes_per_row),
                         "the table of components");
  result.rows = rows_of(all.first(rows), volume);
  return result;
}

void require_usable(const ComponentsOptions& options, const VolumeDescription& volume) {
  if (options.min_mm3 > 0) require_known_spacing(volume, options.input, "a volume in mm3");
}

VolumeDescription description_of_components(std::size_t kept, const VolumeDescription& volume,
                                            const ComponentsOptions& options) {
  return label_description(volume, label_type(kept), made_by(options));
}

}  // namespace octavo
