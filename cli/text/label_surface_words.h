// What surfaces of labels came to, as a table and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "octavo/tasks/surfaces/label_surfaces.h"

namespace octavo::cli {

/// "3 open sides, 0 repeated ones, ...": what keeps a surface from being closed and manifold.
std::string fault_words(const MeshCheck& check);

/// A line for the whole, and a row for each label; of surfaces that were not written those that are
/// at fault.
std::string label_surfaces_text(const LabelSurfacesOptions& options,
                                const LabelSurfacesResult& result);

/// Lengths and volumes are null where the spacing is not known.
nlohmann::ordered_json label_surfaces_json(const LabelSurfacesOptions& options,
                                           const LabelSurfacesResult& result);

}  // namespace octavo::cli
