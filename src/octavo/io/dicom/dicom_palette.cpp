#include "octavo/io/dicom/dicom_palette.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr DicomTag kFirstDescriptor = 0x00281101;  // red, then green and blue
constexpr DicomTag kFirstTable = 0x00281201;
constexpr std::int64_t kIndexChannel = 0;
constexpr std::int64_t kMostColors = 65536;

/// Colors of 8 bits stand in bytes, or each in a word of its own.
std::vector<std::uint16_t> colors_of(const DicomSet& data, DicomTag tag, std::int64_t count,
                                     std::int64_t bits) {
  const std::vector<std::uint16_t> words = data.words(tag);
  if (static_cast<std::int64_t>(words.size()) == count) return words;
  std::vector<std::uint16_t> colors;
  if (bits != 8 || static_cast<std::int64_t>(words.size()) != (count + 1) / 2) return colors;
  for (const std::uint16_t word : words) {
    colors.push_back(static_cast<std::uint16_t>(word & 0xffU));
    colors.push_back(static_cast<std::uint16_t>(word >> 8));
  }
  colors.resize(static_cast<std::size_t>(count));
  return colors;
}

DicomColorTable read_table(const DicomLayout& layout, std::int64_t channel) {
  const auto color = static_cast<DicomTag>(channel - 1);
  const DicomSet data = read_dicom_file(layout.path).data;
  const std::vector<std::uint16_t> descriptor = data.words(kFirstDescriptor + color);
  DicomColorTable table;
  if (descriptor.size() == 3) {
    const std::int64_t count = descriptor[0] == 0 ? kMostColors : descriptor[0];
    table.first_value = layout.is_signed ? static_cast<std::int16_t>(descriptor[1])
                                         : static_cast<std::int64_t>(descriptor[1]);
    table.bits = descriptor[2];
    table.colors = colors_of(data, kFirstTable + color, count, table.bits);
  }
  if (!table.colors.empty() && (table.bits == 8 || table.bits == 16)) return table;
  throw Error(ErrorKind::source_rejected,
              "its color table " + dicom_tag_text(kFirstTable + color) +
                  " is missing, segmented, or not as long as " +
                  dicom_tag_text(kFirstDescriptor + color) + " says",
              layout.path)
      .with_field("channel", "index");
}

}  // namespace

bool has_palette(const DicomLayout& layout) {
  return layout.photometric == "PALETTE COLOR" && layout.samples == 1 &&
         !layout.is_segmentation() && !layout.pixels.is_float;
}

SourceComponents palette_components() {
  SourceComponents components;
  components.channel_names = {"index", "red", "green", "blue"};
  components.channels = static_cast<std::int64_t>(components.channel_names.size());
  return components;
}

std::vector<DicomSlice> choose_palette_color(std::vector<DicomSlice> slices,
                                             std::int64_t channel) {
  if (channel == kIndexChannel) return slices;
  std::map<std::shared_ptr<const DicomLayout>, std::shared_ptr<const DicomLayout>> colored;
  std::shared_ptr<const DicomColorTable> last;
  for (DicomSlice& slice : slices) {
    std::shared_ptr<const DicomLayout>& layout = colored[slice.layout];
    if (layout == nullptr) {
      DicomColorTable table = read_table(*slice.layout, channel);
      if (last != nullptr && table.bits != last->bits) {
        reject(*slice.layout, "its colors have " + std::to_string(table.bits) +
                                  " bits, those of the slices before it " +
                                  std::to_string(last->bits));
      }
      if (last == nullptr || table != *last) {
        last = std::make_shared<const DicomColorTable>(std::move(table));
      }
      auto changed = std::make_shared<DicomLayout>(*slice.layout);
      changed->color_table = last;
      changed->padding_value.reset();
      layout = std::move(changed);
    }
    slice.layout = layout;
    slice.values = {};
  }
  return slices;
}

void look_up_colors(const DicomColorTable& table, VoxelType type,
                    std::span<const std::byte> values, std::span<std::byte> colors) {
  const std::size_t color_bytes = table.bits == 8 ? 1 : 2;
  const auto last = static_cast<std::int64_t>(table.colors.size()) - 1;
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t i = 0; i < values.size() / sizeof(T); ++i) {
      T value;
      std::memcpy(&value, values.data() + i * sizeof(T), sizeof(T));
      const std::int64_t index =
          std::clamp<std::int64_t>(static_cast<std::int64_t>(value) - table.first_value, 0, last);
      const std::uint16_t color = table.colors[static_cast<std::size_t>(index)];
      const auto low = static_cast<std::uint8_t>(color);
      if (color_bytes == 1) colors[i] = static_cast<std::byte>(low);
      else std::memcpy(colors.data() + i * color_bytes, &color, sizeof color);
    }
  });
}

}  // namespace octavo
