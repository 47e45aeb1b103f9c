// --salvage: damaged bricks are filled and named instead of rejected.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "common/options.h"
#include "octavo/tasks/salvage.h"

namespace octavo::cli {

/// The option as it was given.
struct SalvageArguments {
  bool is_asked = false;
  std::string fill;  ///< "lowest", "coarse" or a number in real units
};

void add_salvage_option(Verb verb, SalvageArguments& arguments);

/// Nothing where --salvage was not given.
std::optional<SalvageFilling> salvage_filling(const SalvageArguments& arguments);

/// {"bricks", "damage_count", "damages"}, or null.
nlohmann::ordered_json salvaged_json(const std::optional<SalvageReport>& report);

}  // namespace octavo::cli
