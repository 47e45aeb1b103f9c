#include "text/quantities.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "octavo/core/error.h"

namespace octavo::cli {

namespace {

[[noreturn]] void reject(const std::string& text) {
  throw Error(ErrorKind::invalid_argument, text);
}

/// "a:b" as two texts, either of which may be empty.
std::array<std::string, 2> split_range(const std::string& text, const std::string& what) {
  const std::vector<std::string> ends = split(text, ':');
  if (ends.size() != 2) reject(fmt::format("{}: '{}'; expected FROM:TO", what, escaped(text)));
  return {ends[0], ends[1]};
}

std::vector<std::string> three_parts(const std::string& text, const std::string& what,
                                     const char* form) {
  std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 3) reject(fmt::format("{}: '{}'; expected {}", what, escaped(text), form));
  return parts;
}

}  // namespace

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) parts.emplace_back();
    else parts.back() += c;
  }
  return parts;
}

double parse_number(const std::string& text, const std::string& what) {
  double value = 0;
  const char* end = text.data() + text.size();
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [stop, failure] = std::from_chars(begin, end, value);
  if (failure != std::errc() || stop != end || !std::isfinite(value)) {
    reject(fmt::format("{}: '{}' is not a number", what, escaped(text)));
  }
  return value;
}

std::int64_t parse_integer(const std::string& text, const std::string& what) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data(), end, value);
  if (failure != std::errc() || stop != end) {
    reject(fmt::format("{}: '{}' is not a whole number", what, escaped(text)));
  }
  return value;
}

std::vector<double> parse_numbers(const std::string& text, const std::string& what,
                                  std::size_t count, const char* form) {
  std::vector<double> numbers;
  for (const std::string& part : split(text, ',')) numbers.push_back(parse_number(part, what));
  if (numbers.size() != count) {
    reject(fmt::format("{}: '{}'; expected {}", what, escaped(text), form));
  }
  return numbers;
}

double parse_max_error(const std::string& text) {
  const double error = parse_number(text, "--max-error");
  if (error < 0) reject("--max-error: must not be negative");
  return error;
}

std::uint64_t parse_bytes(const std::string& text) {
  std::size_t digits = text.find_first_not_of("0123456789.");
  if (digits == std::string::npos) digits = text.size();
  const std::string unit = text.substr(digits);
  const std::array<const char*, 5> prefixes = {"", "K", "M", "G", "T"};
  for (std::size_t power = 0; power < prefixes.size() && digits > 0; ++power) {
    const std::string prefix = prefixes[power];
    if (unit != prefix && unit != prefix + "B" && (power == 0 || unit != prefix + "iB")) continue;
    const double bytes = std::ldexp(parse_number(text.substr(0, digits), "bytes"),
                                    static_cast<int>(power) * 10);
    if (bytes >= 1 && bytes < 9e18) return static_cast<std::uint64_t>(bytes);
  }
  reject(fmt::format("'{}' is not an amount of memory; expected a number with K, M, G or T, as 2G",
                     escaped(text)));
}

std::uint64_t parse_voxel_count(const std::string& text) {
  const double voxels = parse_number(text, "voxels");
  if (voxels >= 1 && voxels < 9.2e18) return static_cast<std::uint64_t>(voxels);
  reject(fmt::format("'{}' is not a number of voxels; expected 1 or more, as 1e13", escaped(text)));
}

Point3 parse_point(const std::string& text, const std::string& what) {
  const auto parts = three_parts(text, what, "x,y,z");
  return {parse_number(parts[0], what), parse_number(parts[1], what), parse_number(parts[2], what)};
}

Index3 parse_index(const std::string& text, const std::string& what) {
  const auto parts = three_parts(text, what, "x,y,z");
  return {parse_integer(parts[0], what), parse_integer(parts[1], what),
          parse_integer(parts[2], what)};
}

Point3 parse_spacing(const std::string& text, const std::string& what) {
  Point3 spacing{};
  if (text.find(',') == std::string::npos) spacing.fill(parse_number(text, what));
  else spacing = parse_point(text, what);
  for (const double step : spacing) {
    if (step <= 0) reject(fmt::format("{}: '{}'; must be positive", what, escaped(text)));
  }
  return spacing;
}

std::string box_text(const Box& box) {
  return fmt::format("{}:{},{}:{},{}:{}", box.lo.x, box.hi.x, box.lo.y, box.hi.y, box.lo.z,
                     box.hi.z);
}

AskedBox parse_box(const std::string& text, const std::string& what) {
  const auto parts = three_parts(text, what, "x0:x1,y0:y1,z0:z1");
  AskedBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto ends = split_range(parts[axis], what);
    if (!ends[0].empty()) box.lo[axis] = parse_integer(ends[0], what);
    if (!ends[1].empty()) box.hi[axis] = parse_integer(ends[1], what);
  }
  return box;
}

BoxMm parse_box_mm(const std::string& text, const std::string& what) {
  const auto parts = three_parts(text, what, "x0:x1,y0:y1,z0:z1");
  BoxMm box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto ends = split_range(parts[axis], what);
    box.lo[axis] = parse_number(ends[0], what);
    box.hi[axis] = parse_number(ends[1], what);
  }
  return box;
}

Color parse_color(const std::string& text, const std::string& what) {
  if (const auto color = find_color(text)) return *color;
  reject(
      fmt::format("{}: '{}'; expected #rrggbb or one of {}", what, escaped(text), color_names()));
}

}  // namespace octavo::cli
