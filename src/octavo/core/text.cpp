#include "octavo/core/text.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "octavo/core/text_order.h"

namespace octavo {

namespace {

std::atomic<TextOrder> text_order = TextOrder::xyz;

/// Of three axes in the order of texts.
std::string joined_axes(std::array<std::string, 3> texts, const std::string& separator) {
  if (text_order == TextOrder::zyx) std::swap(texts.front(), texts.back());
  return texts[0] + separator + texts[1] + separator + texts[2];
}

/// At most 63 characters of printf.
template <class... Values>
std::string formatted(const char* format, Values... values) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

}  // namespace

void set_text_order(TextOrder order) noexcept { text_order = order; }

std::string exact_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string number_text(double value) {
  if (std::isnan(value)) return "nan";  // whatever its sign
  return formatted("%.6g", value == 0 ? 0.0 : value);
}

std::pair<std::string, std::string> unlike_texts(double a, double b) {
  constexpr int kAllDigits = 17;
  for (int digits = 6;; ++digits) {
    const std::string of_a = formatted("%.*g", digits, a == 0 ? 0.0 : a);
    const std::string of_b = formatted("%.*g", digits, b == 0 ? 0.0 : b);
    if (of_a != of_b || digits == kAllDigits) return {of_a, of_b};
  }
}

std::string precise_text(double value) { return formatted("%.7g", value == 0 ? 0.0 : value); }

std::string point_text(const Point3& point, const std::string& separator) {
  return joined_axes({number_text(point[0]), number_text(point[1]), number_text(point[2])},
                     separator);
}

std::string size_text(std::int64_t x, std::int64_t y) {
  return std::to_string(x) + " x " + std::to_string(y);
}

std::string size_text(const Size3& size) {
  return joined_axes({std::to_string(size.x), std::to_string(size.y), std::to_string(size.z)},
                     " x ");
}

std::string count_text(std::int64_t count) {
  std::string digits = std::to_string(count);
  const std::size_t first = count < 0 ? 1 : 0;
  for (std::size_t at = digits.size(); at > first + 3;) digits.insert(at -= 3, 1, ',');
  return digits;
}

std::string counted_text(std::int64_t count, const std::string& noun, const std::string& plural) {
  const std::string many = plural.empty() ? noun + "s" : plural;
  return count_text(count) + " " + (count == 1 ? noun : many);
}

std::string bytes_text(std::uint64_t bytes) {
  if (bytes < 1000) return counted_text(static_cast<std::int64_t>(bytes), "byte");
  constexpr std::array<const char*, 4> kUnits = {"kB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes) / 1000;
  std::size_t unit = 0;
  while (value >= 999.95 && unit + 1 < kUnits.size()) {
    value /= 1000;
    ++unit;
  }
  return formatted("%.*f %s", value < 9.995 ? 2 : 1, value, kUnits[unit]);
}

std::string duration_text(double seconds) {
  if (seconds < 9.95) return formatted("%.2g s", std::max(seconds, 0.001));
  const long long whole = std::llround(seconds);
  if (whole < 60) return formatted("%lld s", whole);
  if (whole < 3600) return formatted("%lld min %02lld s", whole / 60, whole % 60);
  return formatted("%lld h %02lld min", whole / 3600, whole / 60 % 60);
}

}  // namespace octavo
