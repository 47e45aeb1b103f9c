#include "octavo/io/tiff_description.h"

#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "octavo/io/header_text.h"
#include "octavo/io/length_unit.h"
#include "octavo/io/source_file.h"
#include "octavo/io/value_unit.h"

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

std::map<std::string, std::string, std::less<>> imagej_fields(std::string_view text) {
  std::map<std::string, std::string, std::less<>> fields;
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

using Fields = std::map<std::string, std::string, std::less<>>;

/// ImageJ's function 0 is c0 + c1 * v; the others are no straight lines.
void read_calibration(Fields& fields, TiffDescription& result) {
  const std::optional<double> function = number(fields["cf"]);
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

void read_imagej(std::string_view text, double x_resolution, double y_resolution,
                 TiffDescription& result) {
  auto fields = imagej_fields(text);
  result.is_imagej = true;
  result.order = "CZT";
  result.channels = count_of(fields["channels"]);
  result.frames = count_of(fields["frames"]);
  result.images = count_of(fields["images"]);
  read_calibration(fields, result);
  const std::optional<double> unit = unit_in_mm(fields["unit"]);
  const std::string unit_name = lower_case(fields["unit"]);
  if (!unit && !unit_name.empty() && !unit_name.starts_with("pixel")) {
    result.unknown_unit = fields["unit"];
  }
  if (!unit) return;
  const std::optional<double> spacing = number(fields["spacing"]);
  if (x_resolution > 0) result.x_mm = *unit / x_resolution;
  if (y_resolution > 0) result.y_mm = *unit / y_resolution;
  if (spacing && *spacing != 0) result.z_mm = std::abs(*spacing) * *unit;
}

/// The value of name="..." in the Pixels element, or nothing.
std::string_view attribute(std::string_view element, const std::string& name) {
  const std::string start = " " + name + "=\"";
  const std::size_t at = element.find(start);
  if (at == std::string_view::npos) return {};
  const std::size_t from = at + start.size();
  const std::size_t end = element.find('"', from);
  return end == std::string_view::npos ? std::string_view{} : element.substr(from, end - from);
}

std::optional<double> ome_length(std::string_view pixels, const std::string& axis) {
  const std::optional<double> value = number(attribute(pixels, "PhysicalSize" + axis));
  const std::string_view unit = attribute(pixels, "PhysicalSize" + axis + "Unit");
  const std::optional<double> unit_mm = unit.empty() ? std::optional(1e-3) : unit_in_mm(unit);
  if (!value || !unit_mm || *value <= 0) return std::nullopt;
  return *value * *unit_mm;
}

void read_ome(std::string_view text, TiffDescription& result) {
  const std::size_t start = text.find("<Pixels");
  if (start == std::string_view::npos) return;
  const std::string_view pixels = text.substr(start, text.find('>', start) - start);
  result.is_ome = true;
  result.channels = count_of(attribute(pixels, "SizeC"));
  result.frames = count_of(attribute(pixels, "SizeT"));
  result.slices = count_of(attribute(pixels, "SizeZ"));
  const std::string_view order = attribute(pixels, "DimensionOrder");
  if (order.starts_with("XY")) result.order = order.substr(2);
  result.x_mm = ome_length(pixels, "X");
  result.y_mm = ome_length(pixels, "Y");
  result.z_mm = ome_length(pixels, "Z");
}

}  // namespace

TiffDescription parse_tiff_description(const std::string& text, double x_resolution,
                                       double y_resolution) {
  TiffDescription result;
  if (text.starts_with("ImageJ=")) read_imagej(text, x_resolution, y_resolution, result);
  if (text.find("<OME") != std::string::npos) read_ome(text, result);
  return result;
}

}  // namespace octavo
