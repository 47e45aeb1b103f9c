#include "octavo/io/images/page_notes.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
#include "octavo/io/source/header_bytes.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxAxes = 16;

struct PlaneAxis {
  char name = 'Q';  ///< as tifffile calls it; Q: it does not say
  std::int64_t size = 1;
};

/// Takes the axes between the brackets of tifffile's first form, shape=(2, 5, 17, 19).
std::vector<PlaneAxis> listed_axes(std::string_view text) {
  std::vector<PlaneAxis> axes;
  for (text = trimmed(text); !text.empty() && text.front() != ')'; text = trimmed(text)) {
    std::int64_t size = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), size);
    if (failure != std::errc() || size < 1 || axes.size() == kMaxAxes) return {};
    axes.push_back({'Q', size});
    text = trimmed(text.substr(static_cast<std::size_t>(end - text.data())));
    if (text.starts_with(',')) text.remove_prefix(1);
  }
  return text.empty() ? std::vector<PlaneAxis>() : axes;
}

/// Behind the value that starts at `at`: where a comma or the end of what holds it stands, or the
/// end of the text. What Python writes is not always JSON (NaN), and may be longer than other
/// texts from strangers; so only strings and brackets are looked at.
std::size_t end_of_value(std::string_view text, std::size_t at) {
  std::size_t depth = 0;
  bool is_string = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (is_string) {
      if (c == '\\') ++at;
      is_string = c != '"';
    } else if (c == '"') {
      is_string = true;
    } else if (c == '{' || c == '[') {
      ++depth;
    } else if (c == '}' || c == ']' || c == ',') {
      if (depth == 0) return at;
      if (c != ',') --depth;
    }
  }
  return text.size();
}

/// What is read of the members of tifffile's second form: those of the user's own may be many.
constexpr std::array<std::string_view, 3> kReadNames = {"shape", "truncated", "axes"};

/// Their values as they are written; nothing where the text is no whole object.
std::map<std::string_view, std::string_view> values_of(std::string_view text) {
  std::map<std::string_view, std::string_view> values;
  for (std::size_t at = 0; text.ends_with('}') && at + 1 < text.size();) {
    const std::size_t end = end_of_value(text, at + 1);
    const std::string_view member = trimmed(text.substr(at + 1, end - at - 1));
    const std::size_t name_end = member.find('"', 1);
    if (member.starts_with('"') && name_end != std::string_view::npos) {
      const std::string_view name = member.substr(1, name_end - 1);
      const std::string_view rest = trimmed(member.substr(name_end + 1));
      const bool is_read = std::ranges::find(kReadNames, name) != kReadNames.end();
      if (is_read && rest.starts_with(':')) values[name] = trimmed(rest.substr(1));
    }
    if (end + 1 >= text.size()) return end < text.size() ? values : decltype(values)();
    at = end;
  }
  return {};
}

/// What one of tifffile's texts says of an array; no axes where the text is none of these.
struct ShapedText {
  std::vector<PlaneAxis> axes;  ///< the last one fastest
  bool is_truncated = false;    ///< the array has one page, of its first plane
};

ShapedText shaped_text(std::string_view text) {
  ShapedText shaped;
  const std::string_view first_form = "shape=(";
  text = trimmed(text);
  if (text.starts_with(first_form)) {
    shaped.axes = listed_axes(text.substr(first_form.size()));
    return shaped;
  }
  if (!text.starts_with('{')) return shaped;
  try {
    auto members = values_of(text);
    if (members["shape"].empty()) return shaped;
    for (const std::string_view item : json_items(members["shape"])) {
      JsonReader size(item);
      size.next();
      const std::optional<std::int64_t> count = size.integer();
      if (!count || *count < 1 || shaped.axes.size() == kMaxAxes) return {};
      shaped.axes.push_back({'Q', *count});
    }
    shaped.is_truncated = members["truncated"] == "true";
    if (members["axes"].empty()) return shaped;
    JsonReader names(members["axes"]);
    if (names.next() != JsonToken::string || names.string().size() != shaped.axes.size()) {
      return shaped;
    }
    for (std::size_t i = 0; i < shaped.axes.size(); ++i) {
      const char name = names.string()[i];
      shaped.axes[i].name = name >= 'a' && name <= 'z' ? static_cast<char>(name - 'a' + 'A') : name;
    }
  } catch (const Error&) {
    return {};
  }
  return shaped;
}

/// Whether the names of axes say that pages hold rows of y and columns of x.
/// axes    of the whole array; `planes` of them are not of a page
bool are_pages_upright(const std::vector<PlaneAxis>& axes, std::size_t planes,
                       const TiffPage& page) {
  const auto are_none_of = [](auto first, auto last, std::string_view names) {
    return std::all_of(first, last, [&](const PlaneAxis& axis) {
      return names.find(axis.name) == std::string_view::npos;
    });
  };
  const auto within = axes.begin() + static_cast<std::ptrdiff_t>(planes);
  if (!are_none_of(axes.begin(), within, "XY")) return false;
  auto axis = within;
  if (page.is_separate) ++axis;
  if (page.height > 1 && !are_none_of(axis, axis + 1, "XZCT")) return false;
  if (page.height > 1) ++axis;
  return page.width == 1 || are_none_of(axis, axis + 1, "YZCT");
}

/// How many of the axes are not of a page; nothing where the page is of another size.
std::optional<std::size_t> axes_of_planes(const std::vector<PlaneAxis>& axes,
                                          const TiffPage& page) {
  std::vector<std::int64_t> within = {page.height, page.width};
  if (page.samples > 1) {
    within.insert(page.is_separate ? within.begin() : within.end(), page.samples);
  }
  std::erase(within, 1);
  if (axes.size() < within.size()) return std::nullopt;
  const std::size_t planes = axes.size() - within.size();
  const auto first = axes.begin() + static_cast<std::ptrdiff_t>(planes);
  const auto has_size = [](const PlaneAxis& axis, std::int64_t size) { return axis.size == size; };
  if (!std::equal(first, axes.end(), within.begin(), has_size)) return std::nullopt;
  return planes;
}

std::int64_t& count_of_axis(char name, TiffDescription& result) {
  return name == 'C' ? result.channels : name == 'T' ? result.frames : result.slices;
}

}  // namespace

void read_shaped_description(const std::string& text, const TiffPage& page,
                             const std::string& path, TiffDescription& result) {
  ShapedText shaped = shaped_text(text);
  std::vector<PlaneAxis>& axes = shaped.axes;
  if (axes.empty()) return;
  std::string names;
  for (const PlaneAxis& axis : axes) names += axis.name;
  std::erase_if(axes, [](const PlaneAxis& axis) { return axis.size == 1; });
  const std::optional<std::size_t> planes = axes_of_planes(axes, page);
  if (!planes) return;
  if (!are_pages_upright(axes, *planes, page)) {
    reject(path, "its tifffile description calls the axes \"" + escaped(names) +
                     "\", by which the rows and columns of a page are not along Y and X; save the "
                     "array in the order ZYX");
  }
  axes.resize(*planes);
  result.program = "tifffile";
  result.is_truncated = shaped.is_truncated;
  result.images = 1;
  // Pages that were written one by one have such a text each.
  if (axes.empty()) return;

  // Names of axes that have none, from the fastest on
  std::string order;
  for (auto axis = axes.rbegin(); axis != axes.rend(); ++axis) {
    const bool is_named = axis->name == 'Z' || axis->name == 'C' || axis->name == 'T';
    const auto is_free = [&](char name) {
      return order.find(name) == std::string::npos &&
             std::ranges::none_of(axes, [&](const PlaneAxis& a) { return a.name == name; });
    };
    const char name = is_named ? axis->name : is_free('Z') ? 'Z' : is_free('T') ? 'T' : ' ';
    if (name == ' ' || order.find(name) != std::string::npos) {
      reject(path, "its tifffile description has " + std::to_string(axes.size()) +
                       " axes of several planes, more than slices, channels and times; save one "
                       "volume as its own file");
    }
    order += name;
    result.images = checked_count(result.images, axis->size, "pages");
    count_of_axis(name, result) = axis->size;
  }

  for (const char name : {'C', 'Z', 'T'}) {
    if (order.find(name) == std::string::npos) order += name;
  }
  result.order = order;
  if (result.slices == 0) result.slices = 1;
}

void read_lsm_record(std::span<const std::byte> record, TiffDescription& result) {
  constexpr std::size_t kRecordBytes = 64;  // to the end of the size of voxels
  constexpr std::int32_t kMagics[] = {0x0300494C, 0x0400494C};
  constexpr double kMmPerMeter = 1000;
  if (record.size() < kRecordBytes) return;
  const HeaderBytes read(record, false);
  const auto number_at = [&](std::size_t at) { return read.at<std::int32_t>(at); };
  if (std::ranges::find(kMagics, number_at(0)) == std::end(kMagics)) return;
  result.program = "Zeiss LSM";
  result.counts_samples = true;
  result.order = "ZTC";
  result.slices = std::max(number_at(16), 1);
  result.channels = std::max(number_at(20), 1);
  result.frames = std::max(number_at(24), 1);
  const auto size_at = [&](std::size_t at) -> std::optional<double> {
    const double mm = kMmPerMeter * read.at<double>(at);
    return std::isfinite(mm) && mm > 0 ? std::optional(mm) : std::nullopt;
  };
  result.x_mm = size_at(40);
  result.y_mm = size_at(48);
  result.z_mm = size_at(56);
}

void read_metamorph_planes(std::int64_t planes, TiffDescription& result) {
  if (planes < 2) return;
  result.program = "MetaMorph";
  result.order = "CZT";
  result.images = planes;
  result.slices = planes;
}

}  // namespace octavo
