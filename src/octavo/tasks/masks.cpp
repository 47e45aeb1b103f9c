#include "octavo/tasks/masks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "octavo/builder/tree_builder.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/storage.h"
#include "octavo/ops/grid/resample.h"
#include "octavo/ops/mask/file_mask.h"
#include "octavo/tasks/geometry_words.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

bool is_same_grid(const VolumeDescription& a, const VolumeDescription& b) {
  return a.size == b.size &&
         largest_shift_mm(a.geometry, b.geometry, a.size) <= shift_tolerance_mm(a.geometry);
}

/// The largest angle between an axis of one grid and the same axis of another.
double largest_turn_degrees(const Geometry& a, const Geometry& b) {
  double turn = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double cosine = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      cosine += a.direction[3 * row + axis] * b.direction[3 * row + axis];
    }
    turn = std::max(turn, std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  return turn * 180 / std::numbers::pi;
}

}  // namespace

std::vector<ValueWindow> any_label() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {{-kInfinity, -1}, {1, kInfinity}};
}

MaskTree read_mask(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                   const TaskContext& context) {
  MaskTree mask;
  const ProgressScope scope(context.watcher(), "mask", reader.levels().size(level).z, "planes");
  context.on_threads([&] {
    mask = mask_of_file(reader, level, windows, context.watcher(), context.max_memory_bytes);
  });
  return mask;
}

OpenedMask open_mask(const std::string& path, const TaskContext& context) {
  std::shared_ptr<const FileReader> reader = open_labels(path, context, kAsMask);
  MaskTree tree = read_mask(*reader, 0, any_label(), context);
  return {path, std::move(reader), std::move(tree)};
}

MaskOnGrid open_mask_on(const VolumeDescription& volume, const std::string& name,
                        const std::string& path, const TaskContext& context) {
  const std::shared_ptr<const FileReader> reader = open_labels(path, context, kAsMask);
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
  const ProgressScope scope(context.watcher(), "resample", volume.size.z, "planes");
  context.on_threads([&] {
    mask.tree =
        resampled_mask(*reader, to_source, volume.size, any_label(), context.watcher(),
                       context.max_memory_bytes);
  });
  return mask;
}

VolumeDescription label_description(const VolumeDescription& volume, VoxelType type,
                                    const MadeBy& made_by) {
  VolumeDescription labels = volume;
  labels.kind = VolumeKind::labels;
  labels.type = type;
  labels.rescale = {};
  labels.coding.reset();
  labels.metadata = volume.metadata.for_labels(made_by);
  return labels;
}

VolumeDescription mm_description(const VolumeDescription& volume, VoxelType type,
                                 const MadeBy& made_by) {
  VolumeDescription lengths = label_description(volume, type, made_by);
  lengths.kind = VolumeKind::grey;
  MetadataFacts facts = lengths.metadata.facts();
  facts.unit = "mm";
  lengths.metadata = Metadata::of(std::move(facts));
  return lengths;
}

std::uint64_t bytes_beside(std::uint64_t held, const TaskContext& context) {
  const std::uint64_t limit = context.max_memory_bytes;
  if (limit == 0) return std::uint64_t{1} << 30;
  return held < limit ? (limit - held) / 2 : 0;
}

BuildResult write_labels(PlaneSource& source, const Output& output, const std::string& work,
                         const TaskContext& context) {
  const BuildOptions options = build_options_for(
      context, output, work, {.kind = VolumeKind::labels, .is_resumable = false});
  return build_file(source, local_storage(), output.path, options, context.watcher());
}

namespace {

TreeBuildOptions tree_build_options_for(const TaskContext& context, const Output& output,
                                        const std::string& work) {
  return {.overwrite = output.overwrite,
          .interrupted = output.overwrite ? Interrupted::discard : Interrupted::reject,
          .has_thumbnail = output.has_thumbnail,
          .threads = context.threads,
          .max_memory_bytes = context.max_memory_bytes,
          .progress_name = work};
}

}  // namespace

BuildResult write_label_tree(const LabelTree& labels, const VolumeDescription& description,
                             const Output& output, const std::string& work,
                             const TaskContext& context) {
  return build_label_file({labels, description}, local_storage(), output.path,
                          tree_build_options_for(context, output, work), context.watcher());
}

BuildResult write_mask(const MaskTree& mask, const VolumeDescription& volume,
                       const MadeBy& made_by, const Output& output,
                       const std::string& work, const TaskContext& context) {
  return write_described_mask(mask, label_description(volume, VoxelType::uint8, made_by), output,
                              work, context);
}

BuildResult write_described_mask(const MaskTree& mask, const VolumeDescription& description,
                                 const Output& output, const std::string& work,
                                 const TaskContext& context) {
  return build_mask_file({mask, description}, local_storage(), output.path,
                         tree_build_options_for(context, output, work), context.watcher());
}

void require_same_grid(const VolumeDescription& volume, const std::string& name,
                       const VolumeDescription& other, const std::string& path,
                       const char* field) {
  if (volume.size != other.size) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("has {} voxels, {} has {}", size_text(other.size), escaped(name),
                            size_text(volume.size)),
                path)
        .with_field(field);
  }
  const double shift = largest_shift_mm(volume.geometry, other.geometry, volume.size);
  if (shift <= shift_tolerance_mm(volume.geometry)) return;
  const double degrees = largest_turn_degrees(volume.geometry, other.geometry);
  const std::string turn =
      degrees < 1e-3 ? "" : fmt::format(", axes turned by up to {} degrees", number_text(degrees));
  throw Error(
      ErrorKind::invalid_argument,
      fmt::format("lies up to {} mm from {}: origin {} against {} mm, spacing {} against {} mm{}",
                  number_text(shift), escaped(name), point_text(other.geometry.origin_mm, ", "),
                  point_text(volume.geometry.origin_mm, ", "),
                  point_text(other.geometry.spacing_mm), point_text(volume.geometry.spacing_mm),
                  turn),
      path)
      .with_field(field);
}

void warn_of_unknown_spacing(const VolumeDescription& volume, const std::string& name,
                             const VolumeDescription& other, const std::string& other_name,
                             const TaskContext& context) {
  const bool is_known = is_spacing_known(volume);
  if (is_known == is_spacing_known(other)) return;
  context.warn((is_known ? other_name : name) +
               ": its spacing is not known and is taken for 1 mm, so that the two grids may not "
               "fit together; give the spacing when it is built");
}

}  // namespace octavo
