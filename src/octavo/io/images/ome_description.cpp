#include "octavo/io/images/ome_description.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "octavo/io/images/xml_nesting.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/length_unit.h"

namespace octavo {

namespace {

constexpr std::string_view kXmlBlanks = " \t\r\n";
constexpr std::size_t kMaxReferenceBytes = 12;
constexpr std::int64_t kMostOfAnAxis = 1 << 20;  // for a list: the product of three is no overflow

/// A character by its number, in UTF-8; nothing for numbers that are none.
std::string utf8(std::uint32_t code) {
  const auto tail = [&](int shift) {
    return static_cast<char>(0x80U | (code >> shift & 0x3fU));
  };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xc0U | code >> 6), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xe0U | code >> 12), tail(6), tail(0)};
  if (code > 0x10ffff) return {};
  return {static_cast<char>(0xf0U | code >> 18), tail(12), tail(6), tail(0)};
}

/// The text that a reference such as "&#181;" or "&amp;" stands for, given without & and ;.
std::optional<std::string> referred(std::string_view name) {
  static const std::map<std::string_view, std::string> kNames = {
      {"amp", "&"}, {"lt", "<"}, {"gt", ">"}, {"quot", "\""}, {"apos", "'"}};
  if (const auto found = kNames.find(name); found != kNames.end()) return found->second;
  if (!name.starts_with('#')) return std::nullopt;
  name.remove_prefix(1);
  const bool is_hex = name.starts_with('x') || name.starts_with('X');
  if (is_hex) name.remove_prefix(1);
  std::uint32_t code = 0;
  const auto [end, failure] =
      std::from_chars(name.data(), name.data() + name.size(), code, is_hex ? 16 : 10);
  if (failure != std::errc() || end != name.data() + name.size()) return std::nullopt;
  return utf8(code);
}

/// A text of XML with its references resolved; those not known stay as they are.
std::string resolved(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const std::size_t end = text.starts_with('&') ? text.substr(0, kMaxReferenceBytes).find(';')
                                                  : std::string_view::npos;
    std::optional<std::string> meant;
    if (end != std::string_view::npos) meant = referred(text.substr(1, end - 1));
    result += meant ? *meant : std::string(1, text.front());
    text.remove_prefix(meant ? end + 1 : 1);
  }
  return result;
}

/// The start of the next element of that name at or behind `from`; npos where there is none.
std::size_t find_element(std::string_view text, std::string_view name, std::size_t from = 0) {
  const std::string start = "<" + std::string(name);
  for (std::size_t at = text.find(start, from); at != std::string_view::npos;
       at = text.find(start, at + 1)) {
    const std::size_t end = at + start.size();
    if (end < text.size() && (kXmlBlanks.find(text[end]) != std::string_view::npos ||
                              text[end] == '>' || text[end] == '/')) {
      return at;
    }
  }
  return std::string_view::npos;
}

/// From '<' to before '>'.
std::string_view tag_at(std::string_view text, std::size_t at) {
  return text.substr(at, std::min(text.find('>', at), text.size()) - at);
}

/// What stands between a tag and the end of its element.
std::string_view content_at(std::string_view text, std::size_t at, std::string_view name) {
  const std::string_view tag = tag_at(text, at);
  if (tag.ends_with('/') || at + tag.size() >= text.size()) return {};
  const std::size_t from = at + tag.size() + 1;
  const std::size_t end = std::min(text.find("</" + std::string(name), from), text.size());
  return text.substr(from, end - from);
}

/// The value of name="..." in a tag; absent where it is not there.
std::optional<std::string> attribute(std::string_view tag, const std::string& name) {
  for (std::size_t at = tag.find(name); at != std::string_view::npos; at = tag.find(name, at + 1)) {
    const std::size_t from = at + name.size() + 2;
    if (at == 0 || kXmlBlanks.find(tag[at - 1]) == std::string_view::npos || from > tag.size()) {
      continue;
    }
    const char quote = tag[from - 1];
    if (tag[from - 2] != '=' || (quote != '"' && quote != '\'')) continue;
    const std::size_t end = tag.find(quote, from);
    if (end == std::string_view::npos) return std::nullopt;
    return resolved(tag.substr(from, end - from));
  }
  return std::nullopt;
}

std::string text_of(std::string_view tag, const std::string& name) {
  return attribute(tag, name).value_or("");
}

/// A whole number from 0 on; -1 for any other text; absent where the attribute is.
std::optional<std::int64_t> count_of(std::string_view tag, const std::string& name) {
  const std::optional<std::string> text = attribute(tag, name);
  if (!text) return std::nullopt;
  std::int64_t value = 0;
  const auto [end, failure] = std::from_chars(text->data(), text->data() + text->size(), value);
  const bool is_whole = failure == std::errc() && end == text->data() + text->size();
  return is_whole && value >= 0 ? value : -1;
}

/// OME tells units apart by their case: "Mm" is a megameter, and "Pm" a petameter.
std::optional<double> ome_unit_in_mm(const std::string& unit) {
  return unit == "Mm" || unit == "Pm" ? std::nullopt : unit_in_mm(unit);
}

std::optional<double> length_mm(std::string_view pixels, const std::string& axis,
                                TiffDescription& result) {
  const std::string text = text_of(pixels, "PhysicalSize" + axis);
  double value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (failure != std::errc() || !std::isfinite(value) || value <= 0) return std::nullopt;
  const std::string unit = attribute(pixels, "PhysicalSize" + axis + "Unit").value_or("um");
  const std::optional<double> unit_mm = ome_unit_in_mm(unit);
  if (!unit_mm) {
    result.unknown_unit = unit;
    return std::nullopt;
  }
  return value * *unit_mm;
}

/// element  from its start to that of the next one
OmePages read_tiff_data(std::string_view element) {
  const std::string_view tag = tag_at(element, 0);
  const std::string_view content = content_at(element, 0, "TiffData");
  OmePages pages;
  pages.page = count_of(tag, "IFD");
  pages.count = count_of(tag, "PlaneCount");
  pages.slice = count_of(tag, "FirstZ").value_or(0);
  pages.channel = count_of(tag, "FirstC").value_or(0);
  pages.time = count_of(tag, "FirstT").value_or(0);
  if (const std::size_t at = find_element(content, "UUID"); at != std::string_view::npos) {
    pages.file_name = text_of(tag_at(content, at), "FileName");
    pages.file_id = std::string(trimmed(content_at(content, at, "UUID")));
  }
  return pages;
}

/// The parts of a description that tell of one image each: those with pixels.
std::vector<std::string_view> images_of(std::string_view text) {
  std::vector<std::string_view> images;
  std::size_t at = find_element(text, "Image");
  if (at == std::string_view::npos) at = find_element(text, "Pixels");
  while (at != std::string_view::npos) {
    const std::size_t next = find_element(text, "Image", at + 1);
    const std::string_view image = text.substr(at, next - at);
    if (find_element(image, "Pixels") != std::string_view::npos) images.push_back(image);
    at = next;
  }
  return images;
}

std::string_view pixels_tag(std::string_view image) {
  return tag_at(image, find_element(image, "Pixels"));
}

/// How many channels there are of those that SizeC counts, where samples that stand in one page
/// count once: as many pages as a slice has at one time.
std::int64_t paged_channels(std::string_view image, std::int64_t channels) {
  const std::size_t at = find_element(image, "Channel");
  if (at == std::string_view::npos) return channels;
  const std::int64_t samples = count_of(tag_at(image, at), "SamplesPerPixel").value_or(1);
  return samples > 0 && channels % samples == 0 ? channels / samples : channels;
}

/// image  has pixels
OmeTiffImage read_image(std::string_view image) {
  const std::string_view pixels = pixels_tag(image);
  const auto size_of = [&](const std::string& name) {
    return std::clamp<std::int64_t>(count_of(pixels, name).value_or(1), 1, kMostOfAnAxis);
  };
  OmeTiffImage result;
  if (image.starts_with("<Image")) result.name = text_of(tag_at(image, 0), "Name");
  result.planes =
      size_of("SizeZ") * paged_channels(image, size_of("SizeC")) * size_of("SizeT");
  result.width = size_of("SizeX");
  result.height = size_of("SizeY");
  return result;
}

/// Its name here where it has one, else that of OME.
std::string voxel_type_of(std::string_view pixels) {
  const std::string type = text_of(pixels, "Type");
  return type == "float" ? "float32" : type == "double" ? "float64" : type;
}

}  // namespace

void read_ome_description(std::string_view text, std::size_t image, TiffDescription& result) {
  const std::string_view whole = text.substr(std::min(text.find("<OME"), text.size()));
  result.damage = nesting_damage(whole);
  result.file_id = text_of(tag_at(whole, 0), "UUID");
  if (const std::size_t at = find_element(text, "BinaryOnly"); at != std::string_view::npos) {
    result.metadata_file = text_of(tag_at(text, at), "MetadataFile");
  }
  const std::vector<std::string_view> images = images_of(text);
  for (const std::string_view each : images) result.ome_images.push_back(read_image(each));
  if (image >= images.size()) return;
  const std::string_view pixels = pixels_tag(images[image]);
  result.program = "OME";
  result.counts_samples = true;
  const auto size_of = [&](const std::string& name) {
    return std::max<std::int64_t>(count_of(pixels, name).value_or(0), 0);
  };
  result.channels = size_of("SizeC");
  result.frames = size_of("SizeT");
  result.slices = size_of("SizeZ");
  result.columns = size_of("SizeX");
  result.rows = size_of("SizeY");
  result.voxel_type = voxel_type_of(pixels);
  const std::string order = text_of(pixels, "DimensionOrder");
  if (order.starts_with("XY")) result.order = order.substr(2);
  result.x_mm = length_mm(pixels, "X", result);
  result.y_mm = length_mm(pixels, "Y", result);
  result.z_mm = length_mm(pixels, "Z", result);
}

void read_ome_pages(std::string_view text, std::size_t image, TiffDescription& result) {
  const std::vector<std::string_view> images = images_of(text);
  if (image >= images.size()) return;
  text = images[image];
  const std::string_view content = content_at(text, find_element(text, "Pixels"), "Pixels");
  std::size_t at = find_element(content, "TiffData");
  while (at != std::string_view::npos) {
    const std::size_t next = find_element(content, "TiffData", at + 1);
    result.ome_pages.push_back(read_tiff_data(content.substr(at, next - at)));
    at = next;
  }
}

}  // namespace octavo
