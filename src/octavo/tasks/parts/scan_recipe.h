// How planes are opened, as text: what a plan keeps for whoever makes its parts.
#pragma once

#include <string>
#include <string_view>

#include "octavo/tasks/files/scan_planes.h"

namespace octavo {

/// What a plan keeps besides the names of inputs, the kind and what BuildOptions hold.
struct ScanRecipe {
  ScanOptions scan;
  std::optional<PlaneInterpolation> between;  ///< as BuildScanOptions::between
  bool has_given_names = false;  ///< labels were given names: those of the plan's metadata
  std::vector<std::string> words;  ///< of a computed volume, for who understands them; else empty
  std::string root;  ///< where relative paths begin; empty: the folder of the plan
};

/// A JSON object with a member for each option that is not the default.
std::string recipe_text(const ScanRecipe& recipe);

/// The recipe of a text. Throws Error{corrupt}, Error{limit_exceeded}
ScanRecipe parse_recipe(std::string_view text);

}  // namespace octavo
