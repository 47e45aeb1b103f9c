#include "octavo/render/numbers.h"

#include <array>
#include <charconv>

namespace octavo {

std::string short_number(double value, int digits) {
  std::array<char, 64> text{};
  const auto written = std::to_chars(text.data(), text.data() + text.size(), value,
                                     std::chars_format::general, digits);
  std::string result(text.data(), written.ptr);
  return result == "-0" ? "0" : result;
}

std::string with_unit(double value, std::string_view unit) {
  const std::string number = short_number(value);
  return unit.empty() ? number : number + " " + std::string(unit);
}

std::string joined(const Point3& point, std::string_view separator) {
  return short_number(point[0]) + std::string(separator) + short_number(point[1]) +
         std::string(separator) + short_number(point[2]);
}

}  // namespace octavo
