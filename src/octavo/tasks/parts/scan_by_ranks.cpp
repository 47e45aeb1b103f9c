#include "octavo/tasks/parts/scan_by_ranks.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "octavo/core/text.h"
#include "octavo/dist/plan_text.h"
#include "octavo/dist/rank_build.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/files/build_scan.h"
#include "octavo/tasks/parts/plan_scan.h"
#include "octavo/tasks/parts/planned_source.h"

namespace octavo {

namespace {

BuildPlan plan_for_all(const ScanByRanksOptions& options, Communicator& ranks,
                       const TaskContext& context) {
  std::string text;
  if (ranks.is_first()) {
    require_scan_output(options.scan);
    PlanResult planned;
    text = plan_text(plan_in_memory({.scan = options.scan, .is_for_ranks = true}, context,
                                    planned));
  }
  const Bytes bytes =
      ranks.broadcast({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return parse_plan({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// Said once: nothing else keeps two jobs apart.
void note_missing_locks(const std::string& path, const TaskContext& context) {
  if (local_storage().has_locks(folder_of(path))) return;
  context.note(path + ": its file system has no locks, so no other job may build it meanwhile");
}

void note_resumed(const BuildPlan& plan, const BuildResult& build, const std::string& path,
                  const TaskContext& context) {
  if (build.resumed_planes == 0) return;
  context.note(path + ": continued behind plane " + std::to_string(build.resumed_planes - 1) +
               " of " + std::to_string(plan.source.size.z));
}

}  // namespace

BuiltByRanks scan_by_ranks(const ScanByRanksOptions& options, Communicator& ranks,
                           const TaskContext& context) {
  const auto start = std::chrono::steady_clock::now();
  const Output& output = options.scan.output;
  const BuildPlan plan = plan_for_all(options, ranks, context);
  if (ranks.is_first()) note_missing_locks(output.path, context);
  RankBuildOptions by_ranks;
  by_ranks.gather = options.gather;
  by_ranks.overwrite = output.overwrite;
  by_ranks.discards_interrupted = output.overwrite;
  by_ranks.work = {context.threads, context.max_memory_bytes,
                   clipped_listener(output.path, context)};

  // The first group of this rank is sought now; the others when their turn comes.
  const std::int64_t first = std::min<std::int64_t>(ranks.rank(), plan.group_count - 1);
  try {
    const auto source =
        open_planned(plan, first_plane_of(plan, first), first_plane_of(plan, first + 1), context);
    BuiltByRanks result{{plan.source, plan.options.kind, {}}, {}};
    result.built.build = build_by_ranks(plan, *source, ranks, local_storage(), output.path,
                                        by_ranks, context.watcher(), &result.report);
    result.built.build.total_seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    note_resumed(plan, result.built.build, output.path, context);
    return result;
  } catch (const Error& error) {
    throw about_scan(error, plan.inputs.front());
  }
}

}  // namespace octavo
