#include "octavo/tasks/files/build_scan.h"

#include "octavo/core/error.h"
#include "octavo/tasks/files/exported_voxels.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

/// Says that a volume of two values is mostly a mask.
void note_mask(const std::string& name, const std::pair<std::int64_t, std::int64_t>& values,
               const TaskContext& context) {
  context.note(name + ": holds two values only, " + std::to_string(values.first) + " and " +
                   std::to_string(values.second) + ", as masks do",
               "two_values");
}

}  // namespace

void require_scan_output(const BuildScanOptions& options) {
  if (!options.output.path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument, "a build writes .8vo files", options.output.path)
        .with_field("output.format");
  }
  require_free(options.output);
  require_no_input(options.output.path, options.inputs);
}

BuiltVolume build_scan(const BuildScanOptions& options, const TaskContext& context) {
  require_scan_output(options);
  const ScanPlanes scan = open_scan_planes(options, context);
  // Headers name further files.
  require_no_input(options.output.path, scan.planes->files().paths);
  const std::string& name = options.inputs.front();
  try {
    const BuildOptions how = build_options_of(options, scan.kind);
    BuiltVolume built = build_planes(*scan.planes, how, options.output, "build", context);
    compare_with_export(scan.planes->files().voxels_sha256, how.repair, built.build, name,
                        options.output.path, context);
    if (*scan.two_values) note_mask(name, **scan.two_values, context);
    return built;
  } catch (const Error& error) {
    throw about_scan(error, name);
  }
}

}  // namespace octavo
