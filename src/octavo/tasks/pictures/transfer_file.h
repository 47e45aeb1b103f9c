// Transfer functions as files in JSON:
//
//     {"points": [{"value": 150, "color": "#d6a880", "opacity": 0},
//                 {"value": 500, "color": "sand", "opacity": 0.7}],
//      "layer_mm": 1, "relative": false, "gradient": [10, 40]}
//
// layer_mm  thickness of a layer that has these opacities; without, the finest spacing
// relative  values 0 .. 1 are shares of the volume's window; without, real values
// gradient  values per mm at which opacity begins and is whole; without, it is so everywhere
#pragma once

#include <string>
#include <string_view>

#include "octavo/render/rays/transfer_function.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Throws Error{invalid_argument} that says what is wrong with which point
TransferFunction parse_transfer(std::string_view text);

/// A preset of that name, or what a file holds.
/// Throws as parse_transfer; Error{io} for what cannot be read
TransferFunction read_transfer(const std::string& name_or_path);

/// "bone, skin, ..."
std::string transfer_preset_names();

}  // namespace octavo
