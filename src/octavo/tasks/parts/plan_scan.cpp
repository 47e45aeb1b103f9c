#include "octavo/tasks/parts/plan_scan.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "octavo/builder/build_memory.h"
#include "octavo/builder/build_setup.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/dist/band_part.h"
#include "octavo/dist/rank_build.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/scan_recipe.h"

namespace octavo {

namespace {

constexpr std::uint64_t kPartBytes = std::uint64_t{4} << 30;
constexpr std::int64_t kPartsThatReadAll = 8;

/// Parts are called as the plan, and a little longer.
void require_part_names(const std::string& plan_path, std::int64_t count) {
  const std::string longest = part_name(plan_path, count - 1, count);
  if (longest.size() <= kMaxNameBytes) return;
  throw Error(ErrorKind::invalid_argument,
              "is too long a name for a plan: its parts would have names of " +
                  std::to_string(longest.size()) + " bytes, and file systems allow " +
                  std::to_string(kMaxNameBytes),
              plan_path);
}

/// Whoever starts as many workers as parts were asked for has some without one.
void note_fewer_parts(const PlanScanOptions& options, const PlanResult& result,
                      const TaskContext& context) {
  const std::string& path = options.scan.output.path;
  if (options.parts.value_or(0) > result.part_count) {
    context.note(path + ": " + counted_text(result.part_count, "part") + " in place of " +
                 count_text(*options.parts) + ": there are no more groups of planes");
  }
  if (options.bands.value_or(0) > result.bands) {
    context.note(path + ": " + counted_text(result.bands, "part shares", "parts share") +
                 " each group in place of " + count_text(*options.bands) +
                 ": there are no more bricks");
  }
}

void require_plan_name(const Output& output) {
  if (output.path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument, "is the name of a volume; name the plan NAME.plan",
                output.path);
  }
  require_part_names(output.path, 1);
  require_free(output);
}

void require_files(const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    if (!is_url(input)) continue;
    throw Error(ErrorKind::invalid_argument,
                "nothing tells whether a source behind a URL stays as it is; download it first",
                public_name(input));
  }
}

void describe_plan(const BuildPlan& plan, const PlaneSource& source, PlanResult& result) {
  const VolumeDescription& volume = plan.source;
  result.volume = volume;
  result.kind = plan.options.kind;
  result.raw_bytes = static_cast<std::uint64_t>(volume.size.voxel_count() *
                                                bytes_per_voxel(volume.type));
  result.group_count = plan.group_count;
  result.planes_per_group = plan.planes_per_group;
  result.group_bytes = plane_bytes(volume) * static_cast<std::uint64_t>(plan.planes_per_group);
  const std::uint64_t whole =
      build_memory_bytes(volume, 1, plan.options.max_error) + source.resident_bytes();
  const std::uint64_t limit = plan.options.max_memory_bytes;
  const std::uint64_t needed =
      plan.bands == 1
          ? whole
          : share_memory_bytes(volume, 1, band_share_bytes(volume, plan.bands)) +
                source.resident_bytes();
  result.is_in_bands = limit != 0 && needed > limit;
  result.part_memory_bytes = result.is_in_bands ? limit : needed;
  result.thread_bytes = kThreadBytes;
  result.can_seek = source.can_seek();
  result.file_count = static_cast<std::int64_t>(plan.files.size());
}

/// What a plan is made of, opened.
struct PlannedPlanes {
  std::unique_ptr<PlaneSource> planes;
  BuildOptions build;
  std::vector<std::string> files;
  std::optional<SliceStack> stack;
  ScanRecipe recipe;
};

PlannedPlanes open_to_plan(const PlanScanOptions& options, const TaskContext& context) {
  const BuildScanOptions& wanted = options.scan;
  PlannedPlanes opened;
  if (options.work) {
    ComputedVolume computed = open_computed(*options.work, context);
    const bool has_thumbnail = computed.build.has_thumbnail;
    opened.planes = std::move(computed.planes);
    opened.build = build_options_for(context, wanted.output, "plan", computed.build);
    opened.build.has_thumbnail = has_thumbnail;
    opened.files = files_of_volume(inputs_of(*options.work)).paths;
    opened.recipe.words = options.words;
    return opened;
  }
  ScanPlanes scan = open_scan_planes(wanted, context);
  opened.planes = std::move(scan.planes);
  opened.build =
      build_options_for(context, wanted.output, "plan", build_options_of(wanted, scan.kind));
  opened.files = opened.planes->files().paths;
  opened.stack = std::move(scan.stack);
  opened.recipe.scan = wanted.scan;
  opened.recipe.between = wanted.between;
  opened.recipe.has_given_names = !wanted.label_names.empty();
  return opened;
}

}  // namespace

std::int64_t part_count_for(const PlanScanOptions& options, std::int64_t group_count,
                            std::uint64_t group_bytes, bool can_seek) {
  if (options.parts) return std::clamp<std::int64_t>(*options.parts, 1, group_count);
  const std::uint64_t part_bytes = options.part_bytes.value_or(kPartBytes);
  const auto per_part = static_cast<std::int64_t>(
      std::max<std::uint64_t>(part_bytes / std::max<std::uint64_t>(group_bytes, 1), 1));
  const std::int64_t count = group_count / per_part + (group_count % per_part != 0 ? 1 : 0);
  return can_seek || options.part_bytes ? count : std::min(count, kPartsThatReadAll);
}

BuildPlan plan_in_memory(const PlanScanOptions& options, const TaskContext& context,
                         PlanResult& result) {
  const std::vector<std::string> inputs =
      options.work ? inputs_of(*options.work) : options.scan.inputs;
  require_files(inputs);
  try {
    PlannedPlanes opened = open_to_plan(options, context);
    const bool has_bands = options.bands.value_or(1) > 1;
    if (has_bands) {
      // The first group is read as parts read theirs: what holds the plan holds them.
      require_bands(*opened.planes, opened.build);
      opened.build.band_bytes = share_band_bytes(
          *opened.planes, opened.build, build_threads(opened.build.threads),
          band_share_bytes(opened.planes->description(), *options.bands));
    }
    if (options.is_for_ranks) {
      require_rank_memory(*opened.planes, opened.build.max_error,
                          {opened.build.threads, opened.build.max_memory_bytes});
    }
    BuildPlan plan = plan_build(*opened.planes, opened.build, context.watcher(),
                                opened.files, opened.stack, options.check);
    if (has_bands) {
      plan.bands = std::min(*options.bands, layer_bricks_of(plan));
      require_bands(plan, *opened.planes);
    }
    describe_plan(plan, *opened.planes, result);
    result.voxels_sha256 = opened.planes->files().voxels_sha256;
    plan.inputs = inputs;
    plan.recipe = recipe_text(opened.recipe);
    plan.part_count =
        plan.bands > 1
            ? plan.group_count * plan.bands
            : part_count_for(options, plan.group_count, result.group_bytes, result.can_seek);
    result.part_count = plan.part_count;
    result.groups_per_part = (plan.group_count + plan.part_count - 1) / plan.part_count;
    result.bands = plan.bands;
    plan.id = id_of(plan);
    return plan;
  } catch (const Error& error) {
    throw inputs.empty() ? error : about_scan(error, inputs.front());
  }
}

PlanResult plan_scan(const PlanScanOptions& options, const TaskContext& context) {
  const Output& output = options.scan.output;
  require_plan_name(output);
  require_root(options.source_root);
  PlanResult result;
  BuildPlan plan = plan_in_memory(options, context, result);
  require_part_names(output.path, plan.part_count);
  std::vector<std::string> files;
  for (const SourceStamp& file : plan.files) files.push_back(file.path);
  require_no_input(output.path, files);
  write_plan(std::move(plan), output.path, options.source_root, output.overwrite);
  note_fewer_parts(options, result, context);
  return result;
}

}  // namespace octavo
