#include "octavo/tasks/parts/join_scan.h"

#include <chrono>
#include <map>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/dist/join_steps.h"
#include "octavo/dist/parts.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/parts/part_numbers.h"
#include "octavo/tasks/parts/part_places.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/standing_part.h"

namespace octavo {

namespace {

/// The paths of all parts. Those that an earlier join has consumed need not be there.
std::vector<std::string> paths_of_all(const BuildPlan& plan, const JoinOptions& options) {
  const PartPlaces places = places_of(options);
  const auto found = found_parts(plan, places, options.plan);
  const std::string& output = options.output.path;
  const bool goes_on = options.consumes_parts && (find_layout(plan, local_storage(), output) ||
                                                  is_sealed(plan, local_storage(), output));
  if (!goes_on) require_all_found(plan, found, places, options.plan);
  std::vector<std::string> paths;
  for (const auto& [part, path] : found) paths.push_back(path);
  return paths;
}

BuiltVolume consume_planned(const BuildPlan& plan, const std::vector<std::string>& paths,
                            const Output& output, const TaskContext& context) {
  const auto start = std::chrono::steady_clock::now();
  BuiltVolume joined{plan.source, plan.options.kind, {}};
  BuildResult& build = joined.build;
  build.file_bytes =
      consume_parts(plan, paths, local_storage(), output.path, output.overwrite,
                    {context.threads, context.max_memory_bytes}, context.watcher(),
                    &build.clipped);
  const auto file = open_volume(output.path, context);
  const std::optional<CodingNote>& coding = file->description().metadata.facts().coding;
  build.raw_bytes = plane_bytes(plan.source) * static_cast<std::uint64_t>(plan.source.size.z);
  build.max_error = file->max_error();
  if (coding) build.detail_errors = coding->detail_errors;
  if (build.detail_errors) build.max_error = file->achieved_error();
  build.coding = file->description().coding;
  build.threads = context.thread_count();
  build.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return joined;
}

}  // namespace

void require_joined_name(const Output& output) {
  if (!output.path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument, "a join writes .8vo files", output.path)
        .with_field("output.format");
  }
  require_free(output);
}

std::string MissingParts::list() const {
  std::vector<std::int64_t> numbers;
  for (const MissingPart& part : missing) numbers.push_back(part.number);
  return part_list_text(numbers);
}

BuiltVolume join_planned(const BuildPlan& plan, const std::vector<std::string>& paths,
                         const Output& output, const TaskContext& context) {
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const std::string& path : paths) {
    context.stop_if_cancelled();
    parts.push_back(PartFile::open(local_storage(), path));
    number_of(plan, *parts.back());
  }
  BuiltVolume joined{plan.source, plan.options.kind, {}};
  joined.build = join_parts(plan, std::move(parts), local_storage(), output.path, output.overwrite,
                            {context.threads, context.max_memory_bytes}, context.watcher());
  discard_steps(plan, local_storage(), output.path);
  return joined;
}

BuiltVolume join_scan(const JoinOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.plan);
  const bool is_done =
      options.consumes_parts && is_sealed(plan, local_storage(), options.output.path);
  if (!is_done) require_joined_name(options.output);
  const std::vector<std::string> paths = paths_of_all(plan, options);
  return options.consumes_parts ? consume_planned(plan, paths, options.output, context)
                                : join_planned(plan, paths, options.output, context);
}

MissingParts missing_parts(const JoinOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.plan);
  const PartPlaces places = places_of(options);
  std::map<std::int64_t, std::string> found;
  if (!places.folder.empty()) {
    found = found_parts(plan, places, options.plan);
  } else {
    for (const std::string& path : places.files) {
      try {
        found.emplace(number_of(plan, *PartFile::open(local_storage(), path)), path);
      } catch (const Error& error) {
        context.note(error.what());
      }
    }
  }
  MissingParts result{plan.part_count, {}};
  const ProgressScope scope(context.watcher(), "prove", plan.part_count, "parts");
  for (std::int64_t part = 0; part < plan.part_count; ++part) {
    context.stop_if_cancelled();
    const auto path = found.find(part);
    try {
      if (path != found.end()) open_whole_part(plan, part, path->second);
      else result.missing.push_back({part, ""});
    } catch (const Error& error) {
      context.note(error.what());
      result.missing.push_back({part, error.what()});
    }
    context.watcher().advance(1);
  }
  return result;
}

}  // namespace octavo
