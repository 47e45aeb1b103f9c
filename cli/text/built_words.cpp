#include "text/built_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/context.h"
#include "octavo/core/text.h"
#include "octavo/tasks/volume_facts.h"
#include "text/detail_words.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

/// What the file promises: nothing to add for a lossless one.
std::string promise_text(const BuiltVolume& built) {
  if (built.build.detail_errors) {
    return ", " + detail_error_words(built.volume, *built.build.detail_errors);
  }
  if (built.build.max_error == 0) return "";
  return ", every voxel within " + distance_text(built.volume, built.build.max_error);
}

/// How many labels have a name.
std::size_t named_count(const BuiltVolume& built) {
  const auto& all = built.volume.metadata.facts().labels.all();
  return static_cast<std::size_t>(std::count_if(
      all.begin(), all.end(), [](const auto& label) { return !label.second.name.empty(); }));
}

std::string names_text(const BuiltVolume& built) {
  const auto count = static_cast<std::int64_t>(named_count(built));
  return count == 0 ? "" : " (" + count_text(count) + " named)";
}

std::string built_text(const BuiltVolume& built, const std::string& output) {
  const BuildResult& build = built.build;
  const VolumeDescription& volume = built.volume;
  const double bits = static_cast<double>(build.file_bytes) * 8 /
                      static_cast<double>(volume.size.voxel_count());
  return fmt::format("{}: {} {} {}{}{}, {} from {} ({:.2f}:1, {:.2f} bits per voxel) in {} "
                     "({:.0f} MB/s, {})\n",
                     shown_path(output), size_text(volume.size), voxel_type_name(volume.type),
                     word_of(built.kind), names_text(built), promise_text(built),
                     bytes_text(build.file_bytes), bytes_text(build.raw_bytes),
                     built.compression_ratio(), bits, duration_text(build.total_seconds),
                     built.mb_per_second(),
                     counted_text(build.threads, "thread"));
}

/// Null where coarse levels hold all voxels.
nlohmann::ordered_json clipped_json(const ClippedVoxels& clipped) {
  if (clipped.count == 0) return nullptr;
  return {{"voxels", clipped.count}, {"farthest", clipped.farthest}, {"limit", clipped.limit}};
}

nlohmann::ordered_json built_json(const BuiltVolume& built, const std::string& output) {
  const BuildResult& build = built.build;
  return {{"output", output},
          {"kind", word_of(built.kind)},
          {"named_labels", named_count(built)},
          {"file_bytes", build.file_bytes},
          {"raw_bytes", build.raw_bytes},
          {"ratio", built.compression_ratio()},
          {"seconds", build.total_seconds},
          {"read_seconds", build.read_seconds},
          {"mb_per_s", built.mb_per_second()},
          {"threads", build.threads},
          {"in_bands", build.is_in_bands},
          {"resumed_planes", build.resumed_planes},
          {"max_error", build.max_error},
          {"max_error_real", built.max_error_real()},
          {"detail_errors", detail_errors_json(build.detail_errors)},
          {"coding", coding_json(build.coding)},
          {"clipped", clipped_json(build.clipped)}};
}

}  // namespace

void print_built(const BuiltVolume& built, const std::string& output, const Context& context) {
  print_result(context, built_json(built, output), built_text(built, output));
}

}  // namespace octavo::cli
