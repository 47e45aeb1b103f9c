#include "common/quantities.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "octavo/core/error.h"

namespace octavo::cli {

namespace {

constexpr const char* kAxisNames = "xyz";

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

Box parse_box(const std::string& text, const Size3& size) {
  const auto parts = three_parts(text, "--box", "x0:x1,y0:y1,z0:z1");
  Box box = box_of(size);
  for (int axis = 0; axis < 3; ++axis) {
    const auto ends = split_range(parts[static_cast<std::size_t>(axis)], "--box");
    if (!ends[0].empty()) box.lo[axis] = parse_integer(ends[0], "--box");
    if (!ends[1].empty()) box.hi[axis] = parse_integer(ends[1], "--box");
    if (box.lo[axis] >= 0 && box.lo[axis] < box.hi[axis] && box.hi[axis] <= size[axis]) continue;
    reject(fmt::format("--box: {} = {}:{}; must be a part of 0:{} that is not empty",
                       kAxisNames[axis], box.lo[axis], box.hi[axis], size[axis]));
  }
  return box;
}

Box parse_box_mm(const std::string& text, const Geometry& geometry, const Size3& size) {
  const auto parts = three_parts(text, "--box-mm", "x0:x1,y0:y1,z0:z1");
  std::array<std::array<double, 2>, 3> ends{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto texts = split_range(parts[axis], "--box-mm");
    ends[axis] = {parse_number(texts[0], "--box-mm"), parse_number(texts[1], "--box-mm")};
  }
  // The eight corners, seen from the grid.
  Point3 low{INFINITY, INFINITY, INFINITY};
  Point3 high{-INFINITY, -INFINITY, -INFINITY};
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const Point3 index = geometry.to_index(
        {ends[0][corner & 1], ends[1][corner >> 1 & 1], ends[2][corner >> 2 & 1]});
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], index[axis]);
      high[axis] = std::max(high[axis], index[axis]);
    }
  }
  constexpr double kRoundingSlack = 1e-6;
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const auto limit = static_cast<double>(size[axis]);
    box.lo[axis] = static_cast<std::int64_t>(
        std::clamp(std::ceil(low[a] - kRoundingSlack), 0.0, limit));
    box.hi[axis] = static_cast<std::int64_t>(
        std::clamp(std::floor(high[a] + kRoundingSlack) + 1, 0.0, limit));
  }
  if (box.is_empty()) {
    const Point3 last = geometry.to_world({static_cast<double>(size.x - 1),
                                           static_cast<double>(size.y - 1),
                                           static_cast<double>(size.z - 1)});
    reject(fmt::format("--box-mm {} holds no voxel; the volume runs from {} to {} mm",
                       escaped(text), point_text(geometry.origin_mm, ", "),
                       point_text(last, ", ")));
  }
  return box;
}

void check_level(const Levels& levels, int level) {
  if (level >= 0 && level < levels.count()) return;
  reject(fmt::format("--level {}; the file has levels 0 to {}", level, levels.count() - 1));
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
  return fmt::format("{:.{}f} {}", value, value < 9.995 ? 2 : 1, kUnits[unit]);
}

std::string duration_text(double seconds) {
  if (seconds < 9.95) return fmt::format("{:.2g} s", std::max(seconds, 0.001));
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string number_text(double value) { return fmt::format("{:.6g}", value == 0 ? 0.0 : value); }

std::string size_text(const Size3& size) {
  return fmt::format("{} x {} x {}", size.x, size.y, size.z);
}

std::string point_text(const Point3& point, const std::string& separator) {
  return number_text(point[0]) + separator + number_text(point[1]) + separator +
         number_text(point[2]);
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

}  // namespace octavo::cli
