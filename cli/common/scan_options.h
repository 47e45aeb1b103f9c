// The options that say how a scan is read: shared by build, verify and compare.
#pragma once

#include "common/options.h"
#include "octavo/tasks/open_scan.h"

namespace octavo::cli {

void add_scan_options(Verb verb, ScanOptions& options);

}  // namespace octavo::cli
