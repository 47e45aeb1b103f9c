#include "octavo/tasks/build_planes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "octavo/builder/build_memory.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

void tell_memory(const PlaneSource& source, const BuildOptions& options,
                 const TaskContext& context) {
  const VolumeDescription& volume = source.description();
  const std::uint64_t held = source.resident_bytes();
  context.detail(fmt::format(
      "{} voxels of {}, {} needed in memory, {} of them by the source", size_text(volume.size),
      voxel_type_name(volume.type),
      bytes_text(build_memory_bytes(volume, context.thread_count(), options.max_error) + held),
      bytes_text(held)));
}

/// What went otherwise than asked.
void tell_outcome(const BuiltVolume& built, const BuildOptions& options, const Output& output,
                  const TaskContext& context) {
  const std::int64_t resumed = built.build.resumed_planes;
  if (resumed > 0) {
    context.note(fmt::format("{}: continued behind plane {} of {}", output.path, resumed - 1,
                             built.volume.size.z));
  }
  if (built.build.is_in_bands) {
    context.note(fmt::format("{}: the limit of memory holds no layer of bricks: built in bands, "
                             "for each of which the planes were read again",
                             output.path));
  }
  if (options.interrupted == Interrupted::resume && resumed == 0) {
    context.note(fmt::format("{}: no interrupted build of it to continue; built from plane 0 on",
                             output.path));
  }
  if (options.max_error > 0 && built.build.max_error == 0) {
    context.note(fmt::format("a max error of {} is below one stored step ({}): built without loss",
                             number_text(options.max_error),
                             number_text(std::abs(built.volume.rescale.slope))));
  }
}

}  // namespace

double BuiltVolume::max_error_real() const {
  return build.max_error * std::abs(volume.rescale.slope);
}

double BuiltVolume::compression_ratio() const {
  return static_cast<double>(build.raw_bytes) /
         static_cast<double>(std::max<std::uint64_t>(build.file_bytes, 1));
}

double BuiltVolume::mb_per_second() const {
  constexpr double kShortestSeconds = 1e-3;
  return static_cast<double>(build.raw_bytes) / 1e6 /
         std::max(build.total_seconds, kShortestSeconds);
}

BuiltVolume build_planes(PlaneSource& source, const BuildOptions& options, const Output& output,
                         const std::string& work, const TaskContext& context) {
  context.require_voxels(source.description().size, output.path);
  tell_memory(source, options, context);
  BuiltVolume built{source.description(), options.kind, {}};
  built.build = build_file(source, local_storage(), output.path,
                           build_options_for(context, output, work, options), context.watcher());
  tell_outcome(built, options, output, context);
  return built;
}

}  // namespace octavo
