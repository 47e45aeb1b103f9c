#include "octavo/tasks/distance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/planes/computed_source.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

constexpr double kMostSteps = 32767;

/// The two ends of what was written so far, mm.
struct DistanceSpan {
  double smallest = 0;
  double largest = 0;
};

void check_options(const DistanceOptions& options, const OpenedMask& mask) {
  const auto is_length = [](double mm) { return std::isfinite(mm) && mm > 0; };
  if (!is_length(options.max_mm.value_or(1))) {
    throw Error(ErrorKind::invalid_argument, "the largest distance must be above 0")
        .with_field("distance.max_mm");
  }
  if (!is_length(options.step_mm.value_or(1))) {
    throw Error(ErrorKind::invalid_argument, "the step must be above 0")
        .with_field("distance.step_mm");
  }
  if (!is_length(options.within_mm.value_or(1))) {
    throw Error(ErrorKind::invalid_argument, "the bound must be above 0")
        .with_field("distance.within_mm");
  }
  require_known_spacing(mask.volume(), mask.path, "a distance in mm");
  const std::uint64_t inside = mask.tree.voxel_count();
  const auto all = static_cast<std::uint64_t>(mask.volume().size.voxel_count());
  if (inside != 0 && inside != all) return;
  throw Error(ErrorKind::invalid_argument,
              inside == 0 ? "the mask is empty: it has no surface to measure from"
                          : "the mask fills the volume: it has no surface to measure from",
              mask.path);
}

/// Throws where no distance is as long as an asked step: voxels would be -1, 0 and 1 alone.
/// largest  compared as a float: distances are
void require_short_step(const DistanceOptions& options, double largest) {
  if (!options.step_mm || static_cast<float>(*options.step_mm) <= static_cast<float>(largest)) {
    return;
  }
  throw Error(ErrorKind::invalid_argument,
              "a step of " + number_text(*options.step_mm) + " mm is longer than the largest " +
                  "distance, " + number_text(largest) + " mm")
      .with_field("distance.step_mm");
}

/// The step of int16 voxels that reach `largest` mm.
double step_for(const DistanceOptions& options, double largest) {
  if (!options.step_mm) return std::exp2(std::ceil(std::log2(largest / kMostSteps)));
  require_short_step(options, largest);
  if (largest <= kMostSteps * *options.step_mm) return *options.step_mm;
  throw Error(ErrorKind::invalid_argument,
              "steps of " + number_text(*options.step_mm) + " mm reach " +
                  number_text(kMostSteps * *options.step_mm) + " mm, distances go up to " +
                  number_text(largest) + " mm")
      .with_field("distance.step_mm");
}

/// What of the bound is left for the codec beside the rounding to steps.
double max_error_of(const DistanceOptions& options, double step_mm) {
  if (!options.within_mm) return 0;
  const double left = *options.within_mm - 0.5 * step_mm;
  if (left >= 0) return left;
  throw Error(ErrorKind::invalid_argument,
              "steps of " + number_text(step_mm) + " mm are off by up to " +
                  number_text(0.5 * step_mm) + " mm, more than " +
                  number_text(*options.within_mm) + " mm")
      .with_field("distance.within_mm");
}

MadeBy made_by(const DistanceOptions& options) {
  MadeBy made("distance");
  made.set("to", word_of(options.to));
  if (options.max_mm) made.set("max_mm", *options.max_mm);
  if (options.within_mm) made.set("within_mm", *options.within_mm);
  return made;
}

/// Distances as voxels of the description; widens `span` to hold them.
void store_distances(const std::vector<float>& mm, const VolumeDescription& volume,
                     std::byte* voxels, DistanceSpan& span) {
  for (const float value : mm) {
    span.smallest = std::min<double>(span.smallest, value);
    span.largest = std::max<double>(span.largest, value);
  }
  if (volume.type == VoxelType::float32) {
    std::memcpy(voxels, mm.data(), mm.size() * sizeof(float));
    return;
  }
  for (std::size_t i = 0; i < mm.size(); ++i) {
    const auto steps = static_cast<std::int16_t>(std::lround(mm[i] / volume.rescale.slope));
    std::memcpy(voxels + i * sizeof steps, &steps, sizeof steps);
  }
}

}  // namespace

DistanceResult distance(const DistanceOptions& options, const TaskContext& context) {
  require_computed(options.output, {options.input});
  const OpenedMask mask = open_mask(options.input, context);
  check_options(options, mask);
  const DistanceSettings settings{options.to, mask.volume().geometry.spacing_mm};
  const double limit = options.max_mm.value_or(std::numeric_limits<double>::infinity());

  // The field.
  const FieldPlan plan =
      plan_distance_field(mask.volume().size, settings, limit,
                          bytes_beside(mask.tree.memory_bytes(), context));
  context.require_memory(mask.tree.memory_bytes() + plan.bytes, "the distances");
  std::unique_ptr<DistanceField> field;
  {
    const ProgressScope scope(context.watcher(), "distance", mask.volume().size.z, "planes");
    context.on_threads([&] {
      field = make_distance_field(inside_of(mask.tree), settings, limit, plan, local_storage(),
                                  folder_of(options.output.path), context.watcher());
    });
  }

  // The file.
  VolumeDescription volume = mm_description(
      mask.volume(), options.is_in_steps ? VoxelType::int16 : VoxelType::float32,
      made_by(options));
  if (options.is_in_steps) {
    volume.rescale.slope = step_for(options, field->largest_mm().value_or(limit));
  }
  const double step_mm = options.is_in_steps ? volume.rescale.slope : 0;
  const BuildOptions build{.kind = VolumeKind::grey,
                           .max_error = max_error_of(options, step_mm),
                           .is_resumable = false};
  DistanceSpan span;
  const std::int64_t plane = volume.size.x * volume.size.y;
  const auto fill = [&](const Box& box, std::byte* voxels) {
    std::vector<float> mm(static_cast<std::size_t>(box.size().z * plane));
    context.on_threads([&] { field->read(box.lo.z, box.hi.z, mm.data()); });
    store_distances(mm, volume, voxels, span);
    // A field with a limit alone does not know sooner how far it went.
    if (field->largest_mm() || box.hi.z < volume.size.z) return;
    require_short_step(options, std::max(span.largest, -span.smallest));
  };
  const auto source = make_computed_source(volume, fill, std::min<std::int64_t>(plan.slab, 16));
  const BuiltVolume built = build_planes(*source, build, options.output, "distance", context);
  return {built.volume, span.smallest, span.largest, plan.hold,
          built.max_error_real() + 0.5 * step_mm, built.build.file_bytes};
}

}  // namespace octavo
