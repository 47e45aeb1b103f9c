#include "common/building.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/progress_line.h"
#include "common/quantities.h"
#include "common/volume_json.h"
#include "octavo/build/builder.h"

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

nlohmann::ordered_json result_json(const BuildResult& result, VolumeKind kind,
                                   const std::string& output, const Context& context) {
  return {{"output", output},
          {"kind", kind_name(kind)},
          {"file_bytes", result.file_bytes},
          {"raw_bytes", result.raw_bytes},
          {"ratio", ratio_of(result)},
          {"seconds", result.total_seconds},
          {"read_seconds", result.read_seconds},
          {"mb_per_s", mb_per_second(result)},
          {"threads", result.threads},
          {"warnings", context.warnings}};
}

}  // namespace

int build_and_report(PlaneSource& source, VolumeKind kind, const std::string& output,
                     const Context& context) {
  const VolumeDescription& volume = source.description();
  BuildOptions options;
  options.kind = kind;
  options.overwrite = context.force;
  options.threads = context.threads;
  options.max_memory_bytes = context.max_memory_bytes;
  context.detail(fmt::format(
      "{} voxels of {}, {} needed in memory, {} of them by the source", size_text(volume.size),
      voxel_type_name(volume.type),
      bytes_text(build_memory_bytes(volume, context.thread_count()) + source.resident_bytes()),
      bytes_text(source.resident_bytes())));
  BuildResult result;
  {
    ProgressLine progress(context);
    result = build_file(source, local_storage(), output, options, progress);
  }
  if (context.json) {
    print_json(result_json(result, kind, output, context));
  } else if (!context.quiet) {
    const double bits = static_cast<double>(result.file_bytes) * 8 /
                        static_cast<double>(volume.size.voxel_count());
    print(fmt::format("{}: {} {} {}, {} from {} ({:.2f}:1, {:.2f} bits per voxel) in {} "
                      "({:.0f} MB/s, {} thread{})\n",
                      output, size_text(volume.size), voxel_type_name(volume.type), kind_name(kind),
                      bytes_text(result.file_bytes), bytes_text(result.raw_bytes), ratio_of(result),
                      bits, duration_text(result.total_seconds), mb_per_second(result),
                      result.threads, result.threads == 1 ? "" : "s"));
  }
  return kExitDone;
}

}  // namespace octavo::cli
