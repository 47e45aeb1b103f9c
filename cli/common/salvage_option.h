// --salvage: damaged bricks are filled and named instead of rejected.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "common/options.h"
#include "octavo/tasks/salvage.h"

namespace octavo::cli {

/// --salvage [FILL]: "lowest", "coarse" or a number in real units.
void add_salvage_option(Verb verb, std::optional<SalvageFilling>& filling);

/// {"bricks", "damage_count", "damages"}, or null.
nlohmann::ordered_json salvaged_json(const std::optional<SalvageReport>& report);

}  // namespace octavo::cli
