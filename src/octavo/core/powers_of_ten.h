// Every eighth power of ten as a number of 64 bits, for the decimal digits of a double.
#pragma once

#include <array>
#include <cstdint>

namespace octavo {

/// 10^decimal = significand * 2^binary, rounded to the nearest; the top bit of the significand is
/// set, so that larger powers have larger binary exponents.
struct PowerOfTen {
  std::uint64_t significand = 0;
  int binary = 0;
  int decimal = 0;
};

/// 10^-300, 10^-292, ... 10^324.
extern const std::array<PowerOfTen, 79> kPowersOfTen;

}  // namespace octavo
