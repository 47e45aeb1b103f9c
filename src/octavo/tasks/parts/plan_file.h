// A plan as a file, whose paths hold wherever the file is read.
//
// Paths below the root stand relative to it in the file, all others absolute. The root is the
// folder that holds the plan, unless another one was named.
#pragma once

#include <string>

#include "octavo/dist/build_plan.h"

namespace octavo {

/// Writes the plan, whose paths are absolute or relative to the working folder.
/// root  where relative paths begin, on this machine; empty: the folder of the plan
/// Returns  the plan with the paths and the id of the file
/// Throws Error{io}
BuildPlan write_plan(BuildPlan plan, const std::string& path, const std::string& root,
                     bool overwrite);

/// Reads a plan and makes its paths absolute.
/// root  where relative paths begin; of a plan without any, the folder of all files of the source
///       on this machine. Empty: as the plan says
/// Throws  as parse_plan; Error{not_octavo} for what is no plan, Error{io}
BuildPlan read_plan(const std::string& path, const std::string& root = "");

/// Throws Error{invalid_argument} for a root that is no folder of this machine.
void require_root(const std::string& root);

/// The file that is proposed for the parts of a plan: "scan.8vo" beside "scan.plan".
std::string proposed_volume(const std::string& plan_path);

/// "scan.part-0007-of-0117" for "scan.plan".
std::string part_name(const std::string& plan_path, std::int64_t part, std::int64_t count);

}  // namespace octavo
