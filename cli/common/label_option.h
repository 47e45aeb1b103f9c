// --label: labels by number or by name.
#pragma once

#include <string>
#include <vector>

#include "common/options.h"
#include "octavo/tasks/asked_labels.h"

namespace octavo::cli {

/// --label, which may be repeated.
/// help  what is done with a label; how it is given is added
Option add_label_option(Verb verb, std::vector<std::string>& labels, const std::string& help);

/// Labels as they are typed: what is a whole number is a label, anything else a name.
/// Throws Error{invalid_argument} for a number beyond 64 bits
AskedLabels parse_labels(const std::vector<std::string>& texts);

}  // namespace octavo::cli
