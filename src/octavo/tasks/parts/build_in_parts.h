// A scan built in parts on one machine: plan, parts, join.
#pragma once

#include <cstdint>
#include <optional>

#include "octavo/tasks/build_planes.h"
#include "octavo/tasks/files/scan_planes.h"

namespace octavo {

struct BuildInPartsOptions {
  BuildScanOptions scan;
  std::int64_t parts = 1;  ///< no more are made than there are groups
  std::optional<std::int64_t> bands = {};  ///< in place of that: so many parts share each group
};

/// Makes the file of build_scan, byte for byte. Parts are made side by side, as many at once as
/// threads and memory allow, in a hidden folder beside the file, which is removed however it ends.
/// Throws  as build_scan, build_part and join_parts; Error{invalid_argument} for a build that is to
///         be resumed
/// Memory  as build_file, for each part that is made at once
BuiltVolume build_in_parts(const BuildInPartsOptions& options, const TaskContext& context);

}  // namespace octavo
