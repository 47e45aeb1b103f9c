#include "octavo/io/images/page_notes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <optional>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/core/json_members.h"
#include "octavo/core/json_reader.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMaxAxes = 16;

struct PlaneAxis {
  char name = 'Q';  ///< as tifffile calls it; Q: it does not say
  std::int64_t size = 1;
};

/// Axes of an array, the last one fastest; empty where the text is none of tifffile's.
std::vector<PlaneAxis> axes_of(const std::string& text) {
  std::vector<PlaneAxis> axes;
  if (!text.starts_with('{')) return axes;
  try {
    const JsonObject members = json_members(text);
    if (members.json_of("shape").empty()) return axes;
    for (const std::string_view item : json_items(members.json_of("shape"))) {
      JsonReader size(item);
      size.next();
      const std::optional<std::int64_t> count = size.integer();
      if (!count || *count < 1 || axes.size() == kMaxAxes) return {};
      axes.push_back({'Q', *count});
    }
    if (members.json_of("axes").empty()) return axes;
    JsonReader names(members.json_of("axes"));
    if (names.next() != JsonToken::string || names.string().size() != axes.size()) return axes;
    for (std::size_t i = 0; i < axes.size(); ++i) axes[i].name = names.string()[i];
  } catch (const Error&) {
    return {};
  }
  return axes;
}

/// Takes the axes that lie within a page out of `axes`; false where the page is of another size.
bool take_page_axes(std::vector<PlaneAxis>& axes, const TiffPage& page) {
  std::vector<std::int64_t> within = {page.height, page.width};
  if (page.samples > 1) {
    within.insert(page.is_separate ? within.begin() : within.end(), page.samples);
  }
  if (axes.size() < within.size()) return false;
  const auto first = axes.end() - static_cast<std::ptrdiff_t>(within.size());
  if (!std::equal(first, axes.end(), within.begin(),
                  [](const PlaneAxis& axis, std::int64_t size) { return axis.size == size; })) {
    return false;
  }
  axes.erase(first, axes.end());
  return true;
}

std::int64_t& count_of_axis(char name, TiffDescription& result) {
  return name == 'C' ? result.channels : name == 'T' ? result.frames : result.slices;
}

template <class T>
T little_endian(std::span<const std::byte> record, std::size_t at) {
  std::array<std::byte, sizeof(T)> bytes{};
  std::copy_n(record.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), bytes.begin());
  if (needs_swap(false)) swap_values(bytes, sizeof(T));
  return std::bit_cast<T>(bytes);
}

}  // namespace

void read_shaped_description(const std::string& text, const TiffPage& page,
                             const std::string& path, TiffDescription& result) {
  std::vector<PlaneAxis> axes = axes_of(text);
  if (axes.empty() || !take_page_axes(axes, page)) return;
  std::erase_if(axes, [](const PlaneAxis& axis) { return axis.size == 1; });
  // Pages that were written one by one have such a text each.
  if (axes.empty()) return;

  // Names of axes that have none, from the fastest on
  std::string order;
  std::uint64_t pages = 1;
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
    pages = checked_mul(pages, static_cast<std::uint64_t>(axis->size), "pages");
    count_of_axis(name, result) = axis->size;
  }

  for (const char name : {'C', 'Z', 'T'}) {
    if (order.find(name) == std::string::npos) order += name;
  }
  result.program = "tifffile";
  result.order = order;
  result.images = static_cast<std::int64_t>(pages);
  if (result.slices == 0) result.slices = 1;
}

void read_lsm_record(std::span<const std::byte> record, TiffDescription& result) {
  constexpr std::size_t kRecordBytes = 64;  // to the end of the size of voxels
  constexpr std::int32_t kMagics[] = {0x0300494C, 0x0400494C};
  constexpr double kMmPerMeter = 1000;
  if (record.size() < kRecordBytes) return;
  const auto number_at = [&](std::size_t at) { return little_endian<std::int32_t>(record, at); };
  if (std::ranges::find(kMagics, number_at(0)) == std::end(kMagics)) return;
  result.program = "Zeiss LSM";
  result.counts_samples = true;
  result.order = "ZTC";
  result.slices = std::max(number_at(16), 1);
  result.channels = std::max(number_at(20), 1);
  result.frames = std::max(number_at(24), 1);
  const auto size_at = [&](std::size_t at) -> std::optional<double> {
    const double mm = kMmPerMeter * little_endian<double>(record, at);
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
