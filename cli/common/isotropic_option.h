// --isotropic: in-between planes for thick slices.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/options.h"
#include "octavo/planes/between/isotropic_source.h"

namespace octavo::cli {

/// --isotropic [METHOD]: linear or cubic.
void add_isotropic_option(Verb verb, std::optional<PlaneInterpolation>& method);

/// The words of a command line, where an --isotropic without a method gets the one it means, so
/// that the name behind it is not taken for one.
std::vector<std::string> with_isotropic_method(std::vector<std::string> words);

}  // namespace octavo::cli
