#include "octavo/tasks/transform.h"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/place_known.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/copy_described.h"
#include "octavo/ops/mask/mask_transform.h"
#include "octavo/planes/computed_source.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/transform_plan.h"

namespace octavo {

namespace {

/// The description of the new volume; its metadata are those for a file made from the input.
VolumeDescription new_description(const std::shared_ptr<const FileReader>& reader,
                                  const TransformPlan& plan) {
  VolumeDescription volume = FilePlanes(reader, plan.level, 1).description();
  if (plan.way == TransformWay::copy) {
    volume.metadata = reader->description().metadata.without_identity();
  }
  volume.size = plan.size;
  volume.geometry = plan.geometry;
  if (plan.way == TransformWay::resample) volume.coding.reset();
  // An origin and axes that moved say no more of the body than they did before.
  if (!plan.is_placed && !is_place_known(reader->description())) {
    volume.metadata.set_place_known(false);
  }
  if (plan.spacing_from) {
    volume.metadata.set_spacing(plan.spacing_from->is_spacing_known(),
                                plan.spacing_from->facts().spacing_source.value_or("file"));
  }
  volume.metadata.set_made_by(plan.made_by);
  return volume;
}

/// Planes computed at once: as many as a brick is high, where they are not too large.
std::int64_t planes_at_once(const VolumeDescription& volume) {
  constexpr std::uint64_t kMostPlaneBytes = std::uint64_t{128} << 20;
  std::uint64_t planes = 64;
  while (planes > 8 && planes * plane_bytes(volume) > kMostPlaneBytes) planes /= 2;
  return std::min(static_cast<std::int64_t>(planes), volume.size.z);
}

/// True where the octree of a mask does the same without its voxels.
bool is_for_mask_tree(const FileReader& reader, const TransformPlan& plan) {
  const ValueRange range = reader.range();
  const VolumeDescription& volume = reader.description();
  const bool is_in_tree = plan.way == TransformWay::move && plan.level == 0 &&
                          (plan.shift == Index3{} || plan.outside == 0);
  return is_in_tree && volume.kind == VolumeKind::labels && volume.type == VoxelType::uint8 &&
         range.min >= 0 && range.max <= 1;
}

/// Whether labels can be lost without a word: where the grids do not meet a warning was given.
bool may_lose_labels(const FileReader& reader, const TransformPlan& plan) {
  const ValueRange range = reader.range();
  return reader.description().kind == VolumeKind::labels && !plan.is_apart &&
         (range.min != 0 || range.max != 0);
}

void warn_of_no_labels(const TransformOptions& options, const TaskContext& context) {
  context.warn(options.output.path + ": is empty; no labeled voxel of " + options.input +
               " is left in the grid");
}

MaskTree moved_mask(const FileReader& reader, const TransformPlan& plan,
                    const TransformOptions& options, const TaskContext& context) {
  constexpr ValueWindow kInside = {1, 1};
  MaskTree mask = read_mask(reader, 0, {&kInside, 1}, context);
  context.on_threads([&] {
    if (plan.turn != AxisTurn{}) mask = turned(mask, plan.turn);
    mask = shifted(mask, plan.shift);
  });
  if (mask.is_empty() && may_lose_labels(reader, plan)) warn_of_no_labels(options, context);
  return mask;
}

/// The file is that of the voxels, but none is looked at.
std::uint64_t write_moved_mask(const FileReader& reader, const TransformPlan& plan,
                               VolumeDescription volume, const TransformOptions& options,
                               const TaskContext& context) {
  if (options.max_error > 0) {
    throw Error(ErrorKind::invalid_argument, "label maps are always lossless")
        .with_field("max_error", "0");
  }
  if (options.preset == Preset::fast) {
    CodingNote coding;
    coding.preset = "fast";
    volume.metadata.set_coding(coding);
  }
  return write_described_mask(moved_mask(reader, plan, options, context), volume, options.output,
                              "transform", context)
      .file_bytes;
}

/// Voxels of the new grid.
FillBox resampled_boxes(std::shared_ptr<const FileReader> reader, const TransformPlan& plan,
                        const TaskContext& context) {
  auto resampler = std::make_shared<const Resampler>(*reader, plan.level, plan.to_source,
                                                     plan.interpolation, plan.outside);
  return [reader, resampler, context](const Box& box, std::byte* voxels) {
    context.on_threads([&] { resampler->fill(box, voxels); });
  };
}

/// The same boxes, from the first plane to the last; warns at the end where none has a label.
FillBox boxes_with_labels(FillBox fill, const VolumeDescription& volume,
                          const TransformOptions& options, const TaskContext& context) {
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(volume.type));
  return [fill = std::move(fill), voxel_bytes, planes = volume.size.z, options, context,
          has_label = false](const Box& box, std::byte* voxels) mutable {
    fill(box, voxels);
    const std::span<const std::byte> bytes(
        voxels, static_cast<std::size_t>(box.size().voxel_count()) * voxel_bytes);
    const auto is_label = [](std::byte part) { return part != std::byte{0}; };
    has_label = has_label || std::any_of(bytes.begin(), bytes.end(), is_label);
    if (!has_label && box.hi.z == planes) warn_of_no_labels(options, context);
  };
}

/// The planes of the new volume.
ComputedVolume computed_planes(FillBox fill, const VolumeDescription& volume,
                               const TransformOptions& options) {
  BuildOptions build{.kind = volume.kind,
                     .preset = options.preset,
                     .max_error = options.max_error,
                     .has_thumbnail = options.output.has_thumbnail,
                     .is_resumable = false};
  return {make_computed_source(volume, std::move(fill), planes_at_once(volume)), build};
}

std::uint64_t write_voxels(const std::shared_ptr<const FileReader>& reader,
                           const TransformPlan& plan, const VolumeDescription& volume,
                           const TransformOptions& options, const TaskContext& context) {
  context.require_voxels(volume.size, options.output.path);
  if (is_for_mask_tree(*reader, plan)) {
    return write_moved_mask(*reader, plan, volume, options, context);
  }
  FillBox fill = resampled_boxes(reader, plan, context);
  if (may_lose_labels(*reader, plan)) {
    fill = boxes_with_labels(std::move(fill), volume, options, context);
  }
  const ComputedVolume computed = computed_planes(std::move(fill), volume, options);
  const BuildOptions build =
      build_options_for(context, options.output, "transform", computed.build);
  require_room_for(volume, build,
                   plane_bytes(volume) * static_cast<std::uint64_t>(planes_at_once(volume)),
                   options.output,
                   plan.is_scaled ? "take a smaller scale" : "take a smaller volume or grid");
  return build_file(*computed.planes, local_storage(), options.output.path, build,
                    context.watcher())
      .file_bytes;
}

template <class T>
void append(const std::vector<T>& more, std::vector<T>& all) {
  all.insert(all.end(), more.begin(), more.end());
}

void require_bound(const TransformOptions& options) {
  if (options.max_error >= 0) return;
  throw Error(ErrorKind::invalid_argument, "the max error must not be negative")
      .with_field("max_error");
}

}  // namespace

void add_step(const TransformStep& step, std::vector<TransformStep>& steps) {
  if (!steps.empty()) {
    auto* const rotations = std::get_if<RotateStep>(&steps.back());
    const auto* const more_rotations = std::get_if<RotateStep>(&step);
    if (rotations != nullptr && more_rotations != nullptr &&
        rotations->is_in_place == more_rotations->is_in_place) {
      append(more_rotations->rotations, rotations->rotations);
      return;
    }
    auto* const mirrors = std::get_if<MirrorStep>(&steps.back());
    const auto* const more_mirrors = std::get_if<MirrorStep>(&step);
    if (mirrors != nullptr && more_mirrors != nullptr &&
        mirrors->is_in_place == more_mirrors->is_in_place) {
      append(more_mirrors->axes, mirrors->axes);
      return;
    }
  }
  steps.push_back(step);
}

ComputedVolume transformed_planes(const TransformOptions& asked, const TaskContext& context) {
  require_bound(asked);
  const std::shared_ptr<const FileReader> reader = open_volume(asked.input, context);
  TransformOptions options = asked;
  options.output.has_thumbnail |= reader->thumbnail_bytes() > 0;
  const TransformPlan plan = plan_transform(options, *reader, context);
  if (plan.way == TransformWay::copy) {
    throw Error(ErrorKind::invalid_argument,
                "nothing is computed: the bricks are copied as they are, which needs no parts",
                options.input);
  }
  const VolumeDescription volume = new_description(reader, plan);
  context.require_voxels(volume.size, options.input);
  return computed_planes(resampled_boxes(reader, plan, context), volume, options);
}

TransformResult transform(const TransformOptions& asked, const TaskContext& context) {
  require_bound(asked);
  const std::shared_ptr<const FileReader> reader = open_volume(asked.input, context);
  TransformOptions options = asked;
  options.output.has_thumbnail |= reader->thumbnail_bytes() > 0;
  const TransformPlan plan = plan_transform(options, *reader, context);
  std::vector<std::string> inputs = {options.input};
  if (!options.grid_of.empty()) inputs.push_back(options.grid_of);
  require_computed(options.output, inputs);
  TransformResult result;
  result.volume = new_description(reader, plan);
  result.operation = plan.operation;
  result.is_copied = plan.way == TransformWay::copy;
  result.summary = plan.summary;
  result.file_bytes =
      result.is_copied
          ? copy_described(open_input(options.input, context), result.volume, local_storage(),
                           options.output.path, options.output.overwrite, context.watcher())
          : write_voxels(reader, plan, result.volume, options, context);
  return result;
}

}  // namespace octavo
