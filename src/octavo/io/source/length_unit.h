// Units of length as headers of other programs spell them.
#pragma once

#include <optional>
#include <string_view>

namespace octavo {

/// Millimeters in a unit ("um", "micron", "cm", "inch", ...; upper case counts as lower case);
/// nothing for pixels and for what is no unit of length.
std::optional<double> unit_in_mm(std::string_view unit);

/// The units above, for messages.
inline constexpr const char* kUnitsRead =
    "nm, um, mm, cm, m, inch and those of OME from femtometer to mile";

}  // namespace octavo
