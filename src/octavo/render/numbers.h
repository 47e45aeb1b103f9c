// Numbers as they stand in pictures.
#pragma once

#include <string>
#include <string_view>

#include "octavo/core/geometry.h"

namespace octavo {

/// At most `digits` significant digits, without trailing zeros; below 1e7 all digits before the
/// point: "0.957", "-1024", "15884", "1e+07".
std::string short_number(double value, int digits = 4);

/// A place to a tenth of the decimal place of `step`, or to a whole: -20.7624 by steps of 0.5 is
/// "-20.76".
std::string place_number(double value, double step);

/// "12.5 HU"; the number alone where there is no unit.
std::string with_unit(double value, std::string_view unit);
std::string with_unit(const std::string& number, std::string_view unit);

/// "0.957 x 0.957 x 1.5" with the separator in between, numbers as short_number gives them.
std::string joined(const Point3& point, std::string_view separator, int digits = 4);

}  // namespace octavo
