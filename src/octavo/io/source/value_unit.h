// Units of measured values as headers of other programs spell them.
#pragma once

#include <string>

namespace octavo {

/// `unit` where it is one that is known ("HU", "mg/ml", "mm2/s", ...; upper case counts as lower
/// case), else empty: such a field takes any text, and text of people stays out of a file.
std::string known_value_unit(const std::string& unit);

}  // namespace octavo
