// The options that say what is built and how: shared by build, plan, and programs that build in
// other ways.
#pragma once

#include <string>
#include <vector>

#include "common/context.h"
#include "common/options.h"
#include "common/scan_arguments.h"
#include "octavo/tasks/files/build_scan.h"

namespace octavo::cli {

struct BuildArguments {
  std::vector<std::string> inputs;
  bool labels = false;
  bool grey = false;
  std::string label_names;
  bool thumbnail = false;
  std::string preset = "small";
  std::string access;
  std::string max_error = "0";
  int keep_details = 0;
  std::string nan;
  std::string infinity;
  std::string isotropic;
  ScanArguments scan;

  bool operator==(const BuildArguments&) const = default;
};

/// The sources, and all options of a build but --output and --resume. Returns the sources.
Option add_build_options(Verb verb, BuildArguments& arguments);

/// output  the file to write
/// Throws  Error{invalid_argument} naming the option that cannot be understood
BuildScanOptions build_scan_options(const BuildArguments& arguments, const std::string& output,
                                    const Context& context);

}  // namespace octavo::cli
