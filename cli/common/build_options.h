// The options that say what is built and how: shared by build, plan, and programs that build in
// other ways.
#pragma once

#include "common/options.h"
#include "octavo/tasks/files/build_scan.h"

namespace octavo::cli {

/// The sources, and all options of a build but --output and --resume. Returns the sources.
Option add_build_options(Verb verb, BuildScanOptions& options);

}  // namespace octavo::cli
