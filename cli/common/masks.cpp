#include "common/masks.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/building.h"
#include "common/geometry_words.h"
#include "common/inputs.h"
#include "common/progress_line.h"
#include "common/quantities.h"
#include "common/volume_json.h"
#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/ops/grid/resample.h"
#include "octavo/ops/mask/file_mask.h"
#include "octavo/planes/computed_source.h"

namespace octavo::cli {

namespace {

/// Every label but 0.
std::vector<ValueWindow> any_label() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {{-kInfinity, -1}, {1, kInfinity}};
}

std::shared_ptr<const FileReader> open_labels(const std::string& path, const Context& context) {
  std::shared_ptr<const FileReader> reader = open_octavo(path, context);
  if (reader->description().kind == VolumeKind::labels) return reader;
  throw Error(ErrorKind::invalid_argument,
              "holds grey values, not a mask; 'octavo threshold' makes one of it", path);
}

bool is_same_grid(const VolumeDescription& a, const VolumeDescription& b) {
  return a.size == b.size &&
         largest_shift_mm(a.geometry, b.geometry, a.size) <= shift_tolerance_mm(a.geometry);
}

}  // namespace

void on_threads(const Context& context, const std::function<void()>& work) {
  tbb::task_arena(context.thread_count()).execute(work);
}

MaskTree read_mask(const FileReader& reader, int level, const std::vector<ValueWindow>& windows,
                   const Context& context) {
  MaskTree mask;
  ProgressLine progress(context);
  const ProgressScope scope(progress, "mask", reader.levels().size(level).z, "planes");
  on_threads(context, [&] {
    mask = mask_of_file(reader, level, windows, progress, context.max_memory_bytes);
  });
  return mask;
}

OpenedMask open_mask(const std::string& path, const Context& context) {
  std::shared_ptr<const FileReader> reader = open_labels(path, context);
  MaskTree tree = read_mask(*reader, 0, any_label(), context);
  return {path, std::move(reader), std::move(tree)};
}

MaskOnGrid open_mask_on(const VolumeDescription& volume, const std::string& name,
                        const std::string& path, Context& context) {
  const std::shared_ptr<const FileReader> reader = open_labels(path, context);
  const VolumeDescription& labels = reader->description();
  warn_of_unknown_spacing(volume, name, labels, path, context);
  if (is_same_grid(volume, labels)) return {read_mask(*reader, 0, any_label(), context), false};
  const std::optional<Affine> to_index = inverse(index_to_world(labels.geometry));
  if (!to_index) throw Error(ErrorKind::invalid_argument, "its direction is flat", path);
  const Affine to_source = chained(index_to_world(volume.geometry), *to_index);
  if (!may_meet(to_source, volume.size, labels.size)) {
    context.warn(fmt::format("{}: lies wholly outside the grid of {}, so that none of it is taken; "
                             "it fills {} mm, the grid {} mm",
                             path, name, extent_text(labels.geometry, labels.size),
                             extent_text(volume.geometry, volume.size)));
  }
  MaskOnGrid mask{MaskTree(), true};
  ProgressLine progress(context);
  const ProgressScope scope(progress, "resample", volume.size.z, "planes");
  on_threads(context, [&] {
    mask.tree =
        resampled_mask(*reader, to_source, volume.size, any_label(), progress,
                       context.max_memory_bytes);
  });
  return mask;
}

VolumeDescription label_description(const VolumeDescription& volume, VoxelType type,
                                    const nlohmann::ordered_json& made_by) {
  VolumeDescription labels = volume;
  labels.kind = VolumeKind::labels;
  labels.type = type;
  labels.rescale = {};
  labels.coding.reset();
  nlohmann::ordered_json metadata = metadata_of(volume);
  // What is said of the values, of the names of labels and of people is not so of these.
  for (const char* name : {"unit", "coding", "source_max_error", "lossy_source", "identity",
                           "segments", "segment", "chosen"}) {
    metadata.erase(name);
  }
  metadata["made_by"] = made_by;
  labels.metadata_json =
      metadata.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return labels;
}

BuildResult write_labels(PlaneSource& source, const std::string& output, const Context& context) {
  ProgressLine progress(context);
  const BuildOptions options =
      with_context({.kind = VolumeKind::labels, .is_resumable = false}, context);
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

std::optional<double> voxel_mm3(const VolumeDescription& volume) {
  if (!is_spacing_known(metadata_of(volume))) return std::nullopt;
  const Point3& spacing = volume.geometry.spacing_mm;
  return spacing[0] * spacing[1] * spacing[2];
}

nlohmann::ordered_json mm3_json(std::uint64_t voxels, const VolumeDescription& volume) {
  const auto mm3 = voxel_mm3(volume);
  return mm3 ? nlohmann::ordered_json(static_cast<double>(voxels) * *mm3) : nullptr;
}

void require_same_grid(const VolumeDescription& volume, const std::string& name,
                       const VolumeDescription& other, const std::string& path,
                       const char* advice) {
  if (volume.size != other.size) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("has {} voxels, {} has {}; {}", size_text(other.size), escaped(name),
                            size_text(volume.size), advice),
                path);
  }
  const double shift = largest_shift_mm(volume.geometry, other.geometry, volume.size);
  if (shift <= shift_tolerance_mm(volume.geometry)) return;
  throw Error(
      ErrorKind::invalid_argument,
      fmt::format("lies up to {} mm from {}: origin {} against {} mm, spacing {} against {} mm; "
                  "{}",
                  number_text(shift), escaped(name), point_text(other.geometry.origin_mm, ", "),
                  point_text(volume.geometry.origin_mm, ", "),
                  point_text(other.geometry.spacing_mm), point_text(volume.geometry.spacing_mm),
                  advice),
      path);
}

void warn_of_unknown_spacing(const VolumeDescription& volume, const std::string& name,
                             const VolumeDescription& other, const std::string& other_name,
                             Context& context) {
  const bool is_known = is_spacing_known(metadata_of(volume));
  if (is_known == is_spacing_known(metadata_of(other))) return;
  context.warn((is_known ? other_name : name) +
               ": its spacing is not known and is taken for 1 mm, so that the two grids may not "
               "fit together; build it with --spacing");
}

void require_memory(std::uint64_t bytes, const char* what, const Context& context) {
  require_memory_within(bytes, context.max_memory_bytes, what, "raise --max-memory");
}

std::string volume_text(std::uint64_t voxels, const VolumeDescription& volume) {
  const std::string count = counted_text(static_cast<std::int64_t>(voxels), "voxel");
  const auto of_one = voxel_mm3(volume);
  if (!of_one) return count + " (spacing not known)";
  const double mm3 = static_cast<double>(voxels) * *of_one;
  if (mm3 >= 1000) return fmt::format("{}, {:.2f} cm3", count, mm3 / 1000);
  return fmt::format("{}, {} mm3", count, number_text(mm3));
}

}  // namespace octavo::cli
