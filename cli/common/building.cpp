#include "common/building.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/progress_line.h"
#include "octavo/core/levels.h"
#include "octavo/core/memory_limit.h"
#include "text/quantities.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

constexpr double kShortestSeconds = 1e-3;

double mb_per_second(const BuildResult& result) {
  return static_cast<double>(result.raw_bytes) / 1e6 /
         std::max(result.total_seconds, kShortestSeconds);
}

double ratio_of(const BuildResult& result) {
  return static_cast<double>(result.raw_bytes) /
         static_cast<double>(std::max<std::uint64_t>(result.file_bytes, 1));
}

/// What the file promises: nothing to add for a lossless one.
std::string promise_text(const BuildResult& result, const VolumeDescription& volume) {
  if (result.max_error == 0) return "";
  return ", every voxel within " +
         distance_text(volume, unit_of(metadata_of(volume)), result.max_error);
}

nlohmann::ordered_json result_json(const BuildResult& result, VolumeKind kind,
                                   const VolumeDescription& volume, const std::string& output,
                                   const Context& context) {
  return {{"output", output},
          {"kind", kind_name(kind)},
          {"file_bytes", result.file_bytes},
          {"raw_bytes", result.raw_bytes},
          {"ratio", ratio_of(result)},
          {"seconds", result.total_seconds},
          {"read_seconds", result.read_seconds},
          {"mb_per_s", mb_per_second(result)},
          {"threads", result.threads},
          {"resumed_planes", result.resumed_planes},
          {"max_error", result.max_error},
          {"max_error_real", result.max_error * std::abs(volume.rescale.slope)},
          {"coding", coding_json(result.coding)},
          {"warnings", context.warnings}};
}

/// Memory of this machine; 0 where it does not say.
std::uint64_t machine_memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return 0;
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_bytes);
}

/// What a build needs with a source that holds `source_bytes`.
std::uint64_t needed_bytes(const VolumeDescription& volume, const BuildOptions& options,
                           std::uint64_t source_bytes) {
  checked_voxel_count(volume.size);
  return build_memory_bytes(volume, options.threads, options.max_error) + source_bytes;
}

}  // namespace

BuildOptions with_context(BuildOptions options, const Context& context) {
  options.overwrite = context.force;
  const bool is_resuming = options.interrupted == Interrupted::resume;
  if (context.force && !is_resuming) options.interrupted = Interrupted::discard;
  options.threads = context.threads;
  options.max_memory_bytes = context.max_memory_bytes;
  options.progress_name = context.verb;
  return options;
}

void require_room_for(const VolumeDescription& volume, const BuildOptions& options,
                      std::uint64_t source_bytes, const std::string& output,
                      const std::string& advice) {
  const bool is_limited = options.max_memory_bytes != 0;
  const std::uint64_t limit = is_limited ? options.max_memory_bytes : machine_memory_bytes();
  try {
    require_memory_within(needed_bytes(volume, options, source_bytes), limit,
                          fmt::format("a result of {} voxels", size_text(volume.size)),
                          is_limited ? advice + ", or raise --max-memory"
                                     : "that is all this machine has; " + advice);
  } catch (const Error& error) {
    throw error.with_path(output);
  }
}

int build_and_report(PlaneSource& source, BuildOptions options, const std::string& output,
                     const Context& context) {
  const VolumeDescription& volume = source.description();
  const VolumeKind kind = options.kind;
  const bool is_resuming = options.interrupted == Interrupted::resume;
  options = with_context(options, context);
  context.detail(fmt::format(
      "{} voxels of {}, {} needed in memory, {} of them by the source", size_text(volume.size),
      voxel_type_name(volume.type),
      bytes_text(build_memory_bytes(volume, context.thread_count(), options.max_error) +
                 source.resident_bytes()),
      bytes_text(source.resident_bytes())));
  BuildResult result;
  {
    ProgressLine progress(context);
    result = build_file(source, local_storage(), output, options, progress);
  }
  if (result.resumed_planes > 0) {
    context.note(fmt::format("{}: continued behind plane {} of {}", output,
                             result.resumed_planes - 1, volume.size.z));
  }
  if (is_resuming && result.resumed_planes == 0) {
    context.note(fmt::format("{}: no interrupted build of it to continue; built from plane 0 on",
                             output));
  }
  if (options.max_error > 0 && result.max_error == 0) {
    context.note(fmt::format("--max-error {} is below one stored step ({}): built without loss",
                             number_text(options.max_error),
                             number_text(std::abs(volume.rescale.slope))));
  }
  if (context.json) {
    print_json(result_json(result, kind, volume, output, context));
  } else if (!context.quiet) {
    const double bits = static_cast<double>(result.file_bytes) * 8 /
                        static_cast<double>(volume.size.voxel_count());
    print(fmt::format("{}: {} {} {}{}, {} from {} ({:.2f}:1, {:.2f} bits per voxel) in {} "
                      "({:.0f} MB/s, {})\n",
                      output, size_text(volume.size), voxel_type_name(volume.type), kind_name(kind),
                      promise_text(result, volume),
                      bytes_text(result.file_bytes), bytes_text(result.raw_bytes), ratio_of(result),
                      bits, duration_text(result.total_seconds), mb_per_second(result),
                      counted_text(result.threads, "thread")));
  }
  return kExitDone;
}

}  // namespace octavo::cli
