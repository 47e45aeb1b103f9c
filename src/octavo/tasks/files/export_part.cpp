#include "octavo/tasks/files/export_part.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

ExportOptions export_options(const ExportPartOptions& options, const FileReader& reader,
                             const TaskContext& context) {
  require_level(reader.levels(), options.level);
  const Size3& size = reader.levels().size(options.level);
  ExportOptions how;
  how.level = options.level;
  how.values = options.values;
  how.overwrite = options.output.overwrite;
  how.threads = context.thread_count();
  if (options.box) how.box = box_within(*options.box, size);
  if (options.box_mm) {
    const VolumeDescription& volume = reader.description();
    require_known_spacing(volume, options.input, "a box in mm", "one in voxels");
    const Geometry geometry = reader.levels().geometry(volume.geometry, options.level);
    how.box = box_within_mm(*options.box_mm, geometry, size);
  }
  return how;
}

/// Of a layer of bricks of the box, as a target of the widest type takes it.
std::uint64_t layer_bytes(const FileReader& reader, const ExportOptions& how) {
  constexpr std::int64_t kWidestVoxel = 4;
  const std::int64_t voxel_bytes =
      how.values == ExportValues::stored ? bytes_per_voxel(reader.description().type)
                                         : kWidestVoxel;
  const Box box = how.box.value_or(box_of(reader.levels().size(how.level)));
  const Size3 size = box.size();
  const std::int64_t planes = std::min(size.z, brick_side_at(reader.levels(), how.level).z);
  return static_cast<std::uint64_t>(size.x * size.y * planes * voxel_bytes);
}

/// "1 mm", "0.5 x 0.5 x 2 mm"
std::string spacing_text(const FileReader& reader, int level) {
  const Point3 mm = reader.levels().geometry(reader.description().geometry, level).spacing_mm;
  const bool is_cube = mm[0] == mm[1] && mm[1] == mm[2];
  return (is_cube ? number_text(mm[0]) : point_text(mm)) + " mm";
}

/// What the file claims though nobody knows it, and what it cannot keep, a warning each.
std::vector<Warning> limit_warnings(const ExportPartOptions& options, const FileReader& reader,
                                        const ExportLimits& limits, const ExportOptions& how) {
  std::vector<Warning> warnings;
  const auto add = [&](const std::string& text) {
    warnings.emplace_back(options.output.path + ": " + text);
  };
  if (limits.claims_spacing) {
    add(fmt::format("the spacing of {} is not known; the file says {}, as its format needs a "
                    "number",
                    options.input, spacing_text(reader, how.level)));
  }
  if (limits.claims_place) {
    add(fmt::format("how the patient lies is not known in {}; other programs may show letters for "
                    "left and right all the same",
                    options.input));
  }
  if (limits.loses_box_start) {
    const Index3& start = how.box->lo;
    add(fmt::format("cannot say that the box begins at voxel {},{},{} of {}, as how the patient "
                    "lies is not known; .nrrd can",
                    start.x, start.y, start.z, options.input));
  }
  if (limits.hides_rescale) {
    const Rescale& rescale = reader.description().rescale;
    warnings.emplace_back(
        fmt::format("{}: holds stored values, and notes that {} x stored + {} are the real ones "
                    "where most programs do not look",
                    options.output.path, number_text(rescale.slope),
                    number_text(rescale.intercept)),
        "export.values");
  }
  return warnings;
}

}  // namespace

ExportPartResult export_part(const ExportPartOptions& options, const TaskContext& context) {
  const std::string& output = options.output.path;
  const ExportFormat format = export_format_of(output);
  require_no_input(output, {options.input});
  const auto reader = salvaging(open_volume(options.input, context), options.salvage, context);
  const ExportOptions how = export_options(options, *reader, context);
  const ExportLimits limits = export_limits(*reader, format, how);
  const std::vector<Warning> warnings = limit_warnings(options, *reader, limits, how);
  // Where a warning is an error nothing is written; elsewhere it is about what was written.
  if (context.is_strict && !warnings.empty()) context.warn(warnings.front());
  context.require_memory(layer_bytes(*reader, how), "a layer of bricks");
  ExportPartResult result;
  read_salvaging(options.salvage, context, [&] {
    result.written =
        export_volume(*reader, local_storage(), output, format, how, context.watcher());
  });
  for (const Warning& warning : warnings) context.warn(warning);
  warn_of_salvaged(*reader, context);
  result.box = how.box.value_or(box_of(reader->levels().size(how.level)));
  result.salvaged = salvage_report(*reader);
  return result;
}

}  // namespace octavo
