// What morphometry found, by name, as every face shows it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/tasks/result_facts.h"
#include "octavo/tasks/structure/morphometry.h"

namespace octavo {

struct MorphometryRow {
  std::string key;    ///< in JSON, and in Python
  std::string label;  ///< as the field abbreviates it
  std::optional<double> value;
  std::string unit;
  std::string words;
};

/// All numbers that were measured, in the order in which they are shown.
/// has_tortuosity  whether it was asked for: an axis that no pore leads along has none
std::vector<MorphometryRow> morphometry_rows(const MorphometryResult& result,
                                             bool has_tortuosity);

/// The same numbers, and what some of them are of: histograms, axes, boxes.
Facts morphometry_facts(const MorphometryResult& result, bool has_tortuosity);

/// What each plane has of the mask, as a list.
FactValue slice_facts(const MorphometryResult& result);

}  // namespace octavo
