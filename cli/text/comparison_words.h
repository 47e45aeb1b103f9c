// How alike two volumes are, in words and JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "octavo/tasks/files/compare.h"

namespace octavo::cli {

/// One line per finding for people: size, place, voxels.
std::vector<std::string> comparison_lines(const Comparison& comparison, const VolumeDescription& a,
                                          const VolumeDescription& b);

nlohmann::ordered_json comparison_json(const Comparison& comparison);

/// "the same: 1,000 voxels, stored values compared", for volumes that are.
std::string equal_text(const CompareResult& result);

/// A row for each label: its voxels in one label map, in the other and in both.
/// Where the two call it by other names, both are shown.
std::string agreement_table(const CompareLabelsResult& result);

nlohmann::ordered_json agreements_json(const CompareLabelsResult& result);

}  // namespace octavo::cli
