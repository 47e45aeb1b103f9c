// The planes of a scan as a build takes them, at once or in parts.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/core/error.h"
#include "octavo/planes/between/isotropic_source.h"
#include "octavo/planes/slice_stack.h"
#include "octavo/tasks/files/two_values.h"
#include "octavo/tasks/open_scan.h"
#include "octavo/tasks/outputs.h"

namespace octavo {

struct BuildScanOptions {
  std::vector<std::string> inputs;  ///< one folder or file, or the files of a stack
  Output output;
  ScanOptions scan;
  /// Nothing: what the source says of itself, else what its name hints at, else grey.
  std::optional<VolumeKind> kind;
  /// A text file with names and colors of the labels, label_names_file.h; or nothing.
  std::string label_names;
  Preset preset = Preset::small;
  std::optional<Access> access;  ///< as CodecSettings::access
  double max_error = 0;  ///< real units; 0: lossless
  int keep_details = 0;  ///< as BuildOptions::keep_details
  FloatRepair repair;
  /// linear or cubic: makes planes between thick slices until voxels are cubes.
  std::optional<PlaneInterpolation> between;
  bool is_resuming = false;  ///< an interrupted build is continued; so may be this one
};

struct ScanPlanes {
  std::unique_ptr<PlaneSource> planes;
  VolumeKind kind = VolumeKind::grey;
  std::optional<SliceStack> stack;  ///< of the slices, where some can be opened apart
  /// Once all planes were read in order, the two values of what may be a mask.
  std::shared_ptr<const TwoValues> two_values;
};

/// Opens the scan with the planes and names that were asked for. Notes where the kind was not asked
/// for.
/// Throws  as open_planes, make_isotropic and read_label_names; Error{invalid_argument} without an
///         input, and for names of labels where there are grey values
ScanPlanes open_scan_planes(const BuildScanOptions& options, const TaskContext& context);

/// How a build is asked for, as far as the context and the output do not say it.
BuildOptions build_options_of(const BuildScanOptions& options, VolumeKind kind);

/// A rejected source that has no name is called `name`.
Error about_scan(const Error& error, const std::string& name);

}  // namespace octavo
