#include "octavo/render/numbers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace octavo {

std::string short_number(double value, int digits) {
  constexpr double kLongest = 1e7;
  std::array<char, 64> text{};
  char* const end = text.data() + text.size();
  const bool is_long = std::abs(value) >= std::pow(10.0, digits) && std::abs(value) < kLongest;
  const auto written =
      is_long ? std::to_chars(text.data(), end, value, std::chars_format::fixed, 0)
              : std::to_chars(text.data(), end, value, std::chars_format::general, digits);
  std::string result(text.data(), written.ptr);
  return result == "-0" ? "0" : result;
}

std::string place_number(double value, double step) {
  const double share = std::min(1.0, std::pow(10.0, std::floor(std::log10(step)) - 1));
  return short_number(std::round(value / share) * share, 9);
}

std::string with_unit(double value, std::string_view unit) {
  return with_unit(short_number(value), unit);
}

std::string with_unit(const std::string& number, std::string_view unit) {
  return unit.empty() ? number : number + " " + std::string(unit);
}

std::string joined(const Point3& point, std::string_view separator, int digits) {
  return short_number(point[0], digits) + std::string(separator) +
         short_number(point[1], digits) + std::string(separator) + short_number(point[2], digits);
}

}  // namespace octavo
