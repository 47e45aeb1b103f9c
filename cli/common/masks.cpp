#include "common/masks.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/inputs.h"
#include "common/progress_line.h"
#include "common/quantities.h"
#include "common/volume_json.h"
#include "octavo/build/computed_source.h"
#include "octavo/core/error.h"
#include "octavo/ops/file_mask.h"

namespace octavo::cli {

void on_threads(const Context& context, const std::function<void()>& work) {
  tbb::task_arena(context.thread_count()).execute(work);
}

MaskTree read_mask(const FileReader& reader, int level, const std::vector<ValueWindow>& windows,
                   const Context& context) {
  MaskTree mask;
  ProgressLine progress(context);
  progress.begin("mask", reader.levels().size(level).z, "planes");
  on_threads(context, [&] { mask = mask_of_file(reader, level, windows, progress); });
  progress.end();
  return mask;
}

OpenedMask open_mask(const std::string& path, const Context& context) {
  std::shared_ptr<const FileReader> reader = open_octavo(path, context);
  if (reader->description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument,
                "holds grey values, not a mask; 'octavo threshold' makes one of it", path);
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  MaskTree tree = read_mask(*reader, 0, {{-kInfinity, -1}, {1, kInfinity}}, context);
  return {path, std::move(reader), std::move(tree)};
}

VolumeDescription label_description(const VolumeDescription& volume, VoxelType type,
                                    const nlohmann::ordered_json& made_by) {
  VolumeDescription labels = volume;
  labels.kind = VolumeKind::labels;
  labels.type = type;
  labels.rescale = {};
  labels.coding.reset();
  nlohmann::ordered_json metadata = metadata_of(volume);
  for (const char* name : {"unit", "coding", "source_max_error", "lossy_source", "identity"}) {
    metadata.erase(name);
  }
  metadata["made_by"] = made_by;
  labels.metadata_json =
      metadata.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return labels;
}

BuildResult write_labels(PlaneSource& source, const std::string& output, const Context& context) {
  BuildOptions options;
  options.kind = VolumeKind::labels;
  options.overwrite = context.force;
  options.interrupted = context.force ? Interrupted::discard : Interrupted::refuse;
  options.threads = context.threads;
  options.max_memory_bytes = context.max_memory_bytes;
  ProgressLine progress(context);
  return build_file(source, local_storage(), output, options, progress);
}

BuildResult write_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const nlohmann::ordered_json& made_by, const std::string& output,
                       const Context& context) {
  const auto source = make_computed_source(
      label_description(volume, VoxelType::uint8, made_by),
      [&](const Box& box, std::byte* voxels) {
        fill_voxels(mask, box, reinterpret_cast<std::uint8_t*>(voxels));
      });
  return write_labels(*source, output, context);
}

double voxel_mm3(const Geometry& geometry) {
  return geometry.spacing_mm[0] * geometry.spacing_mm[1] * geometry.spacing_mm[2];
}

std::string volume_text(std::uint64_t voxels, const VolumeDescription& volume) {
  const std::string count = count_text(static_cast<std::int64_t>(voxels)) + " voxels";
  if (!is_spacing_known(metadata_of(volume))) return count + " (spacing unknown)";
  const double mm3 = static_cast<double>(voxels) * voxel_mm3(volume.geometry);
  if (mm3 >= 1000) return fmt::format("{}, {:.2f} cm3", count, mm3 / 1000);
  return fmt::format("{}, {} mm3", count, number_text(mm3));
}

}  // namespace octavo::cli
