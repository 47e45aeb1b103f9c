// Planes into a file, for every task that builds a grey volume or any scan.
#pragma once

#include <memory>
#include <string>

#include "octavo/builder/builder.h"
#include "octavo/core/option_words.h"
#include "octavo/planes/plane_source.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(Preset) { return in_order<Preset>("small", "fast"); }

constexpr auto option_words(Access) {
  return in_order<Access>(kAccessNames[0], kAccessNames[1], kAccessNames[2]);
}

/// A file that was built.
struct BuiltVolume {
  VolumeDescription volume;  ///< that of the source
  VolumeKind kind = VolumeKind::grey;
  BuildResult build;

  double max_error_real() const;
  double compression_ratio() const;  ///< raw bytes over bytes of the file
  double mb_per_second() const;      ///< of raw bytes, 10^6 each
};

/// A volume that is computed plane by plane, and how it is built.
struct ComputedVolume {
  std::unique_ptr<PlaneSource> planes;
  BuildOptions build;
};

/// Builds the file that `output` names; what the context says goes before `options`. Notes where an
/// interrupted build was continued or not found, and where a max error is too small to matter.
/// work    names the progress
/// Throws  as build_file
BuiltVolume build_planes(PlaneSource& source, const BuildOptions& options, const Output& output,
                         const std::string& work, const TaskContext& context);

}  // namespace octavo
