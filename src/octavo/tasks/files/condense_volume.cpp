#include "octavo/tasks/files/condense_volume.h"

#include <algorithm>
#include <cmath>

#include "octavo/builder/flat_cubes.h"
#include "octavo/core/error.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

constexpr const char* kCondense = "condense";

/// The asked flatness in whole numbers of those that bricks hold.
std::int64_t stored_flat(double flat, const VolumeDescription& volume) {
  constexpr double kMost = 4.6e18;
  constexpr double kRounding = 1e-9;  // of a quotient that should be whole
  double step = volume.rescale.slope == 0 ? 1 : std::abs(volume.rescale.slope);
  if (volume.coding) step *= volume.coding->scale;
  return static_cast<std::int64_t>(std::min(kMost, std::floor(flat / step * (1 + kRounding))));
}

void require_grey(const VolumeDescription& volume, const std::string& path) {
  if (volume.kind == VolumeKind::grey) return;
  throw Error(ErrorKind::invalid_argument,
              "holds labels, which are condensed as they are; only grey volumes have means", path);
}

}  // namespace

ComputedVolume condensed_planes(const CondenseVolumeOptions& options, const TaskContext& context) {
  if (!(options.flat >= 0)) {
    throw Error(ErrorKind::invalid_argument, "the flatness must not be negative");
  }
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, context);
  require_grey(reader->description(), options.input);
  VolumeDescription description = FilePlanes(reader, 0, context.thread_count()).description();
  description.metadata.set_made_by(MadeBy(kCondense).set("flat", options.flat));
  return {make_flat_cubes(reader, description, stored_flat(options.flat, reader->description()),
                          context.thread_count()),
          {.is_resumable = false}};
}

BuiltVolume condense_volume(const CondenseVolumeOptions& options, const TaskContext& context) {
  const ComputedVolume condensed = condensed_planes(options, context);
  require_computed(options.output, {options.input});
  return build_planes(*condensed.planes, condensed.build, options.output, kCondense, context);
}

}  // namespace octavo
