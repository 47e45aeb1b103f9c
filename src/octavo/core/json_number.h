// A double as JSON text that reads back as the same number.
#pragma once

#include <string>

namespace octavo {

/// "0.5", "-1000.0", "1e-05": with a point or an exponent always, so that readers tell it from an
/// integer; "null" for infinities and NaN, which JSON cannot say.
/// Source  F. Loitsch, Printing floating-point numbers quickly and accurately with integers, PLDI
///         2010 (Grisu2): of the shortest digits nearly always, and the same on every machine
std::string json_number(double value);

}  // namespace octavo
