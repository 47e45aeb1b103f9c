#include "octavo/io/nrrd_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "octavo/io/length_unit.h"
#include "octavo/io/source_file.h"

namespace octavo {

namespace {

[[noreturn]] void reject(const std::string& path, const std::string& why) {
  throw Error(ErrorKind::source_rejected, why, path);
}

/// +1 or -1 per world axis: what turns the named space into LPS.
Point3 signs_to_lps(const std::string& space) {
  static const std::map<std::string, Point3> kSigns = {
      {"right-anterior-superior", {-1, -1, 1}},
      {"ras", {-1, -1, 1}},
      {"left-anterior-superior", {1, -1, 1}},
      {"las", {1, -1, 1}}};
  const auto found = kSigns.find(space);
  return found == kSigns.end() ? Point3{1, 1, 1} : found->second;
}

/// The vectors "(a,b,c) none (d,e,f) ..." of a field; "none" is passed over.
std::vector<Point3> vectors(const FieldText& field) {
  std::string flat(field.value);
  const auto count = static_cast<std::size_t>(std::count(flat.begin(), flat.end(), '('));
  std::replace_if(
      flat.begin(), flat.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  for (std::size_t at = 0; (at = lower_case(flat).find("none")) != std::string::npos;) {
    flat.replace(at, 4, 4, ' ');
  }
  const std::vector<double> numbers = FieldText{field.path, field.name, flat}.numbers(count * 3);
  std::vector<Point3> result;
  for (std::size_t i = 0; i < count; ++i) {
    result.push_back({numbers[i * 3], numbers[i * 3 + 1], numbers[i * 3 + 2]});
  }
  return result;
}

/// The quoted words of "units" or "space units".
std::vector<std::string> quoted_words(std::string_view text) {
  std::vector<std::string> result;
  while (true) {
    const std::size_t start = text.find('"');
    const std::size_t end = start == std::string_view::npos ? start : text.find('"', start + 1);
    if (end == std::string_view::npos) return result;
    result.emplace_back(trimmed(text.substr(start + 1, end - start - 1)));
    text.remove_prefix(end + 1);
  }
}

/// Millimetres in each unit of a field, of which `count` are expected; 1 where none is named.
std::vector<double> units_in_mm(const NrrdHeader& header, const std::string& field,
                                std::size_t count, const SourceOptions& options) {
  std::vector<double> factors(count, 1.0);
  if (!header.has(field)) return factors;
  const std::vector<std::string> units = quoted_words(header.text(field));
  if (units.size() != count) {
    reject(header.path(), "\"" + field + "\" names " + std::to_string(units.size()) +
                              " units in quotes, " + std::to_string(count) + " expected");
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (units[i].empty() || units[i] == "???") continue;
    const std::optional<double> factor = unit_in_mm(units[i]);
    if (!factor && !options.spacing_mm) {
      reject(header.path(), "\"" + field + "\" names \"" + escaped(units[i]) +
                                "\", which is no unit that is known here (" + kUnitsRead +
                                "); give --spacing in mm");
    }
    factors[i] = factor.value_or(1.0);
  }
  return factors;
}

bool read_space_directions(const NrrdHeader& header, std::size_t dimension,
                           const SourceOptions& options, Geometry& geometry) {
  const std::vector<Point3> axes = vectors(header.field("space directions"));
  if (axes.size() != dimension || dimension != 3) {
    reject(header.path(), "space directions: " + std::to_string(dimension) +
                              " vectors of 3 numbers expected, " + std::to_string(axes.size()) +
                              " found");
  }
  Point3 signs = signs_to_lps(lower_case(header.text("space")));
  const std::vector<double> units = units_in_mm(header, "space units", 3, options);
  for (std::size_t row = 0; row < 3; ++row) signs[row] *= units[row];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Point3 v = {signs[0] * axes[axis][0], signs[1] * axes[axis][1],
                      signs[2] * axes[axis][2]};
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    geometry.spacing_mm[axis] = length;
    for (std::size_t row = 0; row < 3; ++row) {
      geometry.direction[row * 3 + axis] = v[row] / length;
    }
  }
  if (!header.has("space origin")) return true;
  const std::vector<Point3> origin = vectors(header.field("space origin"));
  if (origin.size() != 1) reject(header.path(), "space origin: one vector expected");
  for (std::size_t row = 0; row < 3; ++row) geometry.origin_mm[row] = signs[row] * origin[0][row];
  return true;
}

/// Old headers: spacings only; "nan" says that an axis has none.
bool read_spacings(const NrrdHeader& header, const NrrdSpaceAxes& space,
                   const SourceOptions& options, Geometry& geometry) {
  if (!header.has("spacings")) return false;
  const std::vector<double> mm = header.field("spacings").numbers();
  if (mm.size() != space.axis_count) {
    reject(header.path(), "spacings: " + std::to_string(space.axis_count) +
                              " numbers expected, " + std::to_string(mm.size()) + " found");
  }
  for (const std::size_t axis : space.axes) {
    if (!std::isfinite(mm[axis])) return false;
  }
  const std::vector<double> units = units_in_mm(header, "units", space.axis_count, options);
  for (std::size_t i = 0; i < space.axes.size(); ++i) {
    geometry.spacing_mm[i] = std::abs(mm[space.axes[i]]) * units[space.axes[i]];
  }
  return true;
}

}  // namespace

void read_nrrd_geometry(const NrrdHeader& header, const NrrdSpaceAxes& space,
                        const SourceOptions& options, SourceFacts& facts) {
  Geometry& geometry = facts.description.geometry;
  facts.spacing_known =
      header.has("space directions")
          ? read_space_directions(header, space.axes.size(), options, geometry)
          : read_spacings(header, space, options, geometry);
}

}  // namespace octavo
