// The options that say how a scan is read: shared by build, verify and compare.
#pragma once

#include <string>

#include "common/options.h"
#include "octavo/tasks/open_scan.h"

namespace octavo::cli {

struct ScanArguments {
  std::string raw;
  std::string spacing;
  std::string series;
  std::string on_gap = "error";
  bool drop_duplicates = false;
  bool untilt = false;
  std::string segment;
  std::string channel;
  std::string time;
  bool no_isolation = false;
  bool keep_identity = false;  ///< asked for by build alone

  bool operator==(const ScanArguments&) const = default;
};

void add_scan_options(Verb verb, ScanArguments& arguments);

/// Throws Error{invalid_argument} naming the option that cannot be understood.
ScanOptions scan_options(const ScanArguments& arguments);

}  // namespace octavo::cli
