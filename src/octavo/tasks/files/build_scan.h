// A scan in, one .8vo file out.
#pragma once

#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/files/scan_planes.h"

namespace octavo {

/// Throws Error{invalid_argument} for a name that does not end in .8vo, and for a source that would
/// be its own output, even with overwrite; as require_free
void require_scan_output(const BuildScanOptions& options);

/// Builds a file from a scan, or from another .8vo file. Notes where the kind was not asked for.
/// Throws  as require_scan_output, open_scan_planes and build_file
/// Memory  as build_file
BuiltVolume build_scan(const BuildScanOptions& options, const TaskContext& context);

}  // namespace octavo
