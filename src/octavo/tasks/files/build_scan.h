// A scan in, one .8vo file out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/planes/between/isotropic_source.h"
#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/open_scan.h"

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

/// Builds a file from a scan, or from another .8vo file. Notes where the kind was not asked for.
/// Throws  as open_planes, make_isotropic, read_label_names and build_file; Error{invalid_argument}
///         for a name that does not end in .8vo, for a scan that would be its own output, even with
///         overwrite, and for names of labels where grey values are built
/// Memory  as build_file
BuiltVolume build_scan(const BuildScanOptions& options, const TaskContext& context);

}  // namespace octavo
