#include "octavo/tasks/parts/build_in_parts.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/storage/unchanged.h"
#include "octavo/tasks/files/build_scan.h"
#include "octavo/tasks/files/exported_voxels.h"
#include "octavo/tasks/parts/join_scan.h"
#include "octavo/tasks/parts/make_parts.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/plan_scan.h"

namespace octavo {

namespace {

constexpr const char* kPlanName = "scan.plan";  // that parts have their names from

/// Whether a folder holds parts and nothing else.
bool holds_parts_alone(const std::string& folder) {
  std::error_code problem;
  for (const auto& entry : std::filesystem::directory_iterator(folder, problem)) {
    const std::string name = entry.path().filename().string();
    if (name.find("scan.part-") > 1) return false;  // one that grows begins with a dot
  }
  return !problem;
}

/// Removes what killed builds of `output` left: folders of parts in which nobody works any more.
void remove_left_parts(const std::string& output) {
  std::error_code none;
  for (const std::string& name : list_temporaries(local_storage(), output)) {
    const auto lock = local_storage().lock_left(name);
    if (lock && holds_parts_alone(name)) std::filesystem::remove_all(name, none);
  }
}

/// Holds parts until they are joined; removed with all that stands in it.
class PartsFolder {
 public:
  explicit PartsFolder(const std::string& output)
      : folder_(made_beside(output)) {}
  ~PartsFolder() {
    std::error_code none;
    std::filesystem::remove_all(folder_.path, none);
  }
  PartsFolder(const PartsFolder&) = delete;
  PartsFolder& operator=(const PartsFolder&) = delete;

  const std::string& path() const { return folder_.path; }

 private:
  static TemporaryFile made_beside(const std::string& output) {
    remove_left_parts(output);
    return create_temporary_folder(local_storage(), output);
  }

  TemporaryFile folder_;
};

/// The progress of works that run side by side, as one: only what they advance passes through.
class SharedProgress final : public Progress {
 public:
  SharedProgress(Progress& all, const std::atomic<bool>& has_failed)
      : all_(all), has_failed_(has_failed) {}
  void begin(std::string_view, std::int64_t, std::string_view) override {}
  void advance(std::int64_t units) override { all_.advance(units); }
  void end() override {}
  bool is_cancelled() const override { return has_failed_ || all_.is_cancelled(); }

 private:
  Progress& all_;
  const std::atomic<bool>& has_failed_;
};

/// How many parts are made at once: a thread each, as far as memory goes.
std::int64_t parts_at_once(const PlanResult& plan, const TaskContext& context) {
  const auto threads = static_cast<std::uint64_t>(context.thread_count());
  std::uint64_t count = std::min<std::uint64_t>(threads, static_cast<std::uint64_t>(
                                                             plan.part_count));
  if (context.max_memory_bytes == 0) return static_cast<std::int64_t>(count);
  const auto needed = [&](std::uint64_t parts) {
    return parts * plan.part_memory_bytes + (threads - parts) * plan.thread_bytes;
  };
  while (count > 1 && needed(count) > context.max_memory_bytes) --count;
  return static_cast<std::int64_t>(count);
}

/// Makes all parts; the first failure ends them all and is thrown.
std::map<std::int64_t, std::string> make_all_parts(const BuildPlan& plan, const std::string& folder,
                                        std::int64_t at_once, const TaskContext& context) {
  std::map<std::int64_t, std::string> paths;
  for (std::int64_t part = 0; part < plan.part_count; ++part) {
    paths[part] =
        (std::filesystem::path(folder) / part_name(kPlanName, part, plan.part_count)).string();
  }
  std::atomic<bool> has_failed = false;
  std::mutex mutex;
  std::exception_ptr failure;
  SharedProgress progress(context.watcher(), has_failed);
  TaskContext own = context;
  own.progress = &progress;
  own.threads = static_cast<int>(std::max<std::int64_t>(1, context.thread_count() / at_once));
  if (own.max_memory_bytes != 0) own.max_memory_bytes /= static_cast<std::uint64_t>(at_once);
  const auto tell = [&mutex](auto listener) {
    return [&mutex, listener](auto&&... said) {
      const std::lock_guard lock(mutex);
      if (listener) listener(said...);
    };
  };
  own.on_warning = tell(context.on_warning);
  own.on_note = tell(context.on_note);
  own.on_detail = tell(context.on_detail);

  std::atomic<std::int64_t> next = 0;
  const auto work = [&] {
    for (std::int64_t part = next++; part < plan.part_count && !has_failed; part = next++) {
      try {
        // Clipped floats are those of the file: the join counts them.
        make_part(plan, part, paths.at(part), context.thread_count(), {}, {}, own);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!has_failed.exchange(true)) failure = std::current_exception();
      }
    }
  };
  std::vector<std::jthread> threads;
  for (std::int64_t i = 1; i < at_once; ++i) threads.emplace_back(work);
  work();
  threads.clear();
  if (failure) std::rethrow_exception(failure);
  return paths;
}

/// The parts in a folder of their own beside the output, and the join of them.
BuiltVolume build_and_join(const BuildPlan& plan, const Output& output, std::int64_t at_once,
                           const TaskContext& context) {
  const PartsFolder folder(output.path);
  std::map<std::int64_t, std::string> paths;
  {
    // Each of the parts that share a group reads all of its planes
    const ProgressScope scope(context.watcher(), "parts", (plan.bands + 1) * plan.source.size.z,
                              "plane passes");
    paths = make_all_parts(plan, folder.path(), at_once, context);
  }
  return join_planned(plan, paths, output, context);
}

}  // namespace

BuiltVolume build_in_parts(const BuildInPartsOptions& options, const TaskContext& context) {
  const auto start = std::chrono::steady_clock::now();
  const BuildScanOptions& scan = options.scan;
  if (scan.is_resuming) {
    throw Error(ErrorKind::invalid_argument, "a build in parts is not resumed")
        .with_field("is_resuming");
  }
  if (options.parts < 1) throw Error(ErrorKind::invalid_argument, "a build has one part or more");
  require_scan_output(scan);
  PlanResult planned;
  const BuildPlan plan = plan_in_memory(
      {.scan = scan, .parts = options.parts, .bands = options.bands}, context, planned);
  const std::int64_t at_once = parts_at_once(planned, context);
  context.detail(std::to_string(plan.part_count) + " parts, " + std::to_string(at_once) +
                 " at once");
  BuiltVolume built;
  try {
    built = build_and_join(plan, scan.output, at_once, context);
  } catch (const Error& error) {
    throw with_unchanged(local_storage(), error, scan.output.path);
  }
  compare_with_export(planned.voxels_sha256, plan.options.repair, built.build,
                      scan.inputs.front(), scan.output.path, context);
  built.build.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return built;
}

}  // namespace octavo
