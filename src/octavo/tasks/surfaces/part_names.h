// Names for the files of labels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"

namespace octavo {

/// A name for a file of each label, without ending: that of the label with letters and digits of
/// any script, ". _ -" and "_" in place of anything else, "label_7" for one without a name. Names
/// that Windows reserves begin with "_", a dot at the end is "_". Where
/// two are equal, also but for case, the numbers of their labels follow them.
std::vector<std::string> part_names(const std::vector<std::int64_t>& labels,
                                    const LabelNames& names);

}  // namespace octavo
