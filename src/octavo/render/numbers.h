// Numbers as they stand in pictures.
#pragma once

#include <string>
#include <string_view>

#include "octavo/core/geometry.h"

namespace octavo {

/// At most `digits` significant digits, without trailing zeros: "0.957", "-1024", "1e+07".
std::string short_number(double value, int digits = 4);

/// "12.5 HU"; the number alone where there is no unit.
std::string with_unit(double value, std::string_view unit);

/// "0.957 x 0.957 x 1.5" with the separator in between.
std::string joined(const Point3& point, std::string_view separator);

}  // namespace octavo
