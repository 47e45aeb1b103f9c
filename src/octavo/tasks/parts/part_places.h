// Where the parts of a plan stand.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "octavo/dist/build_plan.h"
#include "octavo/tasks/parts/join_scan.h"

namespace octavo {

/// A folder in which parts have their names, or files.
struct PartPlaces {
  std::string folder;
  std::vector<std::string> files;
};

PartPlaces places_of(const JoinOptions& options);

/// "FOLDER/scan.part-0007-of-0117".
std::string path_of_part(const std::string& folder, const std::string& plan_path,
                         std::int64_t part, std::int64_t count);

/// The files of parts, by number. Those in a folder need not be parts.
/// Throws  for given files as PartFile::open; Error{invalid_argument} for one of another plan and
///         for a part that is given twice
std::map<std::int64_t, std::string> found_parts(const BuildPlan& plan, const PartPlaces& places,
                                                const std::string& plan_path);

/// Throws Error{io} that lists the parts which were not found.
void require_all_found(const BuildPlan& plan, const std::map<std::int64_t, std::string>& found,
                       const PartPlaces& places, const std::string& plan_path);

}  // namespace octavo
