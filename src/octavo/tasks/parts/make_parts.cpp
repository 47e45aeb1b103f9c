#include "octavo/tasks/parts/make_parts.h"

#include <algorithm>
#include <filesystem>

#include "octavo/builder/build_setup.h"
#include "octavo/core/error.h"
#include "octavo/dist/band_part.h"
#include "octavo/dist/parts.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/files/scan_planes.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/planned_source.h"
#include "octavo/tasks/parts/standing_part.h"

namespace octavo {

namespace {

/// The parts that are to be made.
std::vector<std::int64_t> wanted_parts(const MakePartsOptions& options, MakePartsResult& result,
                                       const TaskContext& context) {
  const std::int64_t count = result.part_count;
  if (!options.parts.empty()) return parse_part_list(options.parts, count);
  if (options.variables) result.scheduled = scheduled_parts(options.variables, count);
  if (result.scheduled) {
    context.note(scheduled_text(*result.scheduled, count));
    return result.scheduled->parts;
  }
  if (count == 1) return {0};
  throw Error(ErrorKind::invalid_argument,
              "which of " + std::to_string(count) +
                  " parts? No scheduler has set a number in the environment",
              options.plan)
      .with_field("parts.which");
}

void make_folder(const std::string& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) throw Error(ErrorKind::io, problem.message(), folder);
}

bool is_loose_link(const std::string& path) {
  std::error_code problem;
  return std::filesystem::is_symlink(path, problem) && !std::filesystem::exists(path, problem);
}

/// Whether the part need not be made.
bool is_kept(const BuildPlan& plan, std::int64_t part, const std::string& path,
             const TaskContext& context) {
  if (local_storage().path_type(path) == PathType::missing) return false;
  try {
    open_whole_part(plan, part, path);
    return true;
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::io) {
      if (!is_loose_link(path)) throw;
      throw Error(ErrorKind::io, "is a link to a file that is not there; remove it", path);
    }
    if (error.kind() == ErrorKind::invalid_argument) throw error.with_field("parts.plan");
    if (error.kind() == ErrorKind::not_octavo) {
      throw Error(ErrorKind::invalid_argument, "is no part of a build", path)
          .with_field("parts.plan");
    }
    context.note(std::string(error.what()) + ": it is made anew");
    return false;
  }
}

/// Where a file of the plan is gone the source is not the one that was planned.
Error about_planned(const Error& error, const BuildPlan& plan) {
  const bool is_planned = std::ranges::find(plan.files, error.path(), &SourceStamp::path) !=
                          plan.files.end();
  const bool is_gone = error.kind() == ErrorKind::io && is_planned &&
                       local_storage().path_type(error.path()) == PathType::missing;
  if (!is_gone) return about_scan(error, plan.inputs.front());
  return Error(ErrorKind::source_rejected,
               "is missing, and was there when the build was planned; restore it, or plan again",
               error.path());
}

}  // namespace

MadePart make_part(const BuildPlan& plan, std::int64_t part, const std::string& path,
                   int threads_of_all, const ClippedListener& on_clipped,
                   const WorkParser& parser, const TaskContext& context) {
  const PartPlace place = place_of(plan, part);
  try {
    const auto source = open_planned(plan, first_plane_of(plan, place.first_group),
                                     first_plane_of(plan, place.end_group), context, parser);
    // Each band of a group counts the floats of all of it; one of them is enough to say so.
    const bool is_first = place.first_brick == 0;
    const PartWork work = {context.threads, context.max_memory_bytes,
                           is_first ? on_clipped : ClippedListener{},
                           threads_of_all};
    if (place.is_band()) {
      build_band(plan, *source, place, local_storage(), path, work, context.watcher());
    } else {
      build_part(plan, *source, place.first_group, place.end_group, local_storage(), path, work,
                 context.watcher());
    }
  } catch (const Error& error) {
    throw about_planned(error, plan);
  }
  return {part, path, local_storage().open_read(path)->size(), false};
}

MakePartsResult make_parts(const MakePartsOptions& options, const TaskContext& context) {
  require_root(options.source_root);
  const BuildPlan plan = read_plan(options.plan, options.source_root);
  context.require_voxels(plan.source.size, options.plan);
  MakePartsResult result;
  result.part_count = plan.part_count;
  const std::vector<std::int64_t> parts = wanted_parts(options, result, context);
  const std::string folder = options.folder.empty() ? folder_of(options.plan) : options.folder;
  make_folder(folder);
  for (const std::int64_t part : parts) {
    context.stop_if_cancelled();
    const std::string path =
        (std::filesystem::path(folder) / part_name(options.plan, part, plan.part_count)).string();
    if (!options.overwrite && is_kept(plan, part, path, context)) {
      result.parts.push_back({part, path, local_storage().open_read(path)->size(), true});
    } else {
      result.parts.push_back(make_part(plan, part, path, 0, clipped_listener(path, context),
                                       options.parser, context));
    }
  }
  return result;
}

}  // namespace octavo
