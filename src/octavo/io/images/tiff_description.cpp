#include "octavo/io/images/tiff_description.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "octavo/core/checked.h"
#include "octavo/io/images/ome_description.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/length_unit.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/value_unit.h"

namespace octavo {

namespace {

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::int64_t count_of(std::string_view text) {
  const std::optional<double> value = number(text);
  return value && *value >= 0 && *value < 1e15 ? static_cast<std::int64_t>(*value) : 0;
}

using Fields = std::map<std::string, std::string, std::less<>>;

Fields imagej_fields(std::string_view text) {
  Fields fields;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const std::size_t equals = line.find('=');
    if (equals != std::string_view::npos) {
      fields[std::string(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return fields;
}

/// `count` numbers between blanks; nothing where there are more, fewer or other words.
template <std::size_t count>
std::optional<std::array<double, count>> numbers(std::string_view text) {
  std::array<double, count> values{};
  for (double& value : values) {
    text = trimmed(text);
    const std::string_view word = text.substr(0, text.find(' '));
    const std::optional<double> read = number(word);
    if (!read) return std::nullopt;
    value = *read;
    text.remove_prefix(word.size());
  }
  return trimmed(text).empty() ? std::optional(values) : std::nullopt;
}

/// What our exports note beside ImageJ's lines, which say it less exactly or not at all.
void read_export_notes(Fields& fields, TiffDescription& result) {
  constexpr double kSameSpacing = 1e-5;
  result.origin_mm = numbers<3>(fields["origin_mm"]);
  result.direction = numbers<9>(fields["direction"]);
  result.is_place_known = fields["place_known"] == "1";
  const auto rescale = numbers<2>(fields["rescale"]);
  if (rescale && rescale->front() != 0) result.rescale = Rescale{rescale->front(), rescale->back()};
  const auto spacing = numbers<3>(fields["spacing_mm"]);
  if (!spacing || !result.x_mm || !result.y_mm || !result.z_mm) return;
  // Another program may have changed its own lines since.
  const Point3 told{*result.x_mm, *result.y_mm, *result.z_mm};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (std::abs((*spacing)[axis] - told[axis]) > kSameSpacing * told[axis]) return;
  }
  result.x_mm = (*spacing)[0];
  result.y_mm = (*spacing)[1];
  result.z_mm = (*spacing)[2];
}

/// ImageJ's function 0 is c0 + c1 * v; the others are no straight lines.
void read_calibration(Fields& fields, TiffDescription& result) {
  const std::optional<double> function = number(fields["cf"]);
  if (!function) result.value_unit = known_value_unit(fields["vunit"]);
  if (!function || *function < 0) return;
  const std::optional<double> intercept = number(fields["c0"]);
  const std::optional<double> slope = number(fields["c1"]);
  if (*function == 0 && intercept && slope && *slope != 0) {
    result.rescale = Rescale{*slope, *intercept};
    result.value_unit = known_value_unit(fields["vunit"]);
  } else {
    result.other_function = count_of(fields["cf"]);
    result.has_other_function = true;
  }
}

/// Millimeters of the unit along one axis. ImageJ writes that of y or z only where it is not that
/// of x.
std::optional<double> axis_unit(Fields& fields, const std::string& name, TiffDescription& result) {
  const std::string unit = fields[name].empty() ? fields["unit"] : fields[name];
  const std::optional<double> mm = unit_in_mm(unit);
  const bool is_silent = unit.empty() || lower_case(unit).starts_with("pixel");
  if (!mm && !is_silent && result.unknown_unit.empty()) result.unknown_unit = unit;
  return mm;
}

void read_imagej(std::string_view text, double x_resolution, double y_resolution,
                 TiffDescription& result) {
  auto fields = imagej_fields(text);
  result.is_imagej = true;
  result.program = "ImageJ";
  result.order = "CZT";
  result.channels = count_of(fields["channels"]);
  result.frames = count_of(fields["frames"]);
  result.images = count_of(fields["images"]);
  result.slices = count_of(fields["slices"]);
  if (result.images == 0) {
    const std::int64_t slices = std::max<std::int64_t>(result.slices, 1);
    const std::int64_t parts = checked_count(std::max<std::int64_t>(result.channels, 1),
                                             std::max<std::int64_t>(result.frames, 1), "images");
    result.images = checked_count(slices, parts, "images");
  }
  read_calibration(fields, result);
  const std::optional<double> x_unit = axis_unit(fields, "unit", result);
  const std::optional<double> y_unit = axis_unit(fields, "yunit", result);
  const std::optional<double> z_unit = axis_unit(fields, "zunit", result);
  const std::optional<double> spacing = number(fields["spacing"]);
  if (x_unit && x_resolution > 0) result.x_mm = *x_unit / x_resolution;
  if (y_unit && y_resolution > 0) result.y_mm = *y_unit / y_resolution;
  if (z_unit && spacing && *spacing != 0) result.z_mm = std::abs(*spacing) * *z_unit;
  read_export_notes(fields, result);
}

}  // namespace

TiffDescription parse_tiff_description(const std::string& text, double x_resolution,
                                       double y_resolution, std::size_t ome_image) {
  TiffDescription result;
  // SCIFIO writes the lines of ImageJ, which reads them so.
  const bool has_lines = text.starts_with("ImageJ=") || text.starts_with("SCIFIO=");
  if (has_lines) read_imagej(text, x_resolution, y_resolution, result);
  if (text.find("<OME") != std::string::npos) read_ome_description(text, ome_image, result);
  return result;
}

}  // namespace octavo
