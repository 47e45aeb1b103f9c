#include "support/dicom_samples.h"

#include "support/source_files.h"

namespace octavo::testing {

namespace {

std::string u16(std::uint16_t value) { return bytes_of<std::uint16_t>({value}); }
std::string u32(std::uint32_t value) { return bytes_of<std::uint32_t>({value}); }

std::string item(const std::string& content) {
  return u16(0xfffe) + u16(0xe000) + u32(static_cast<std::uint32_t>(content.size())) + content;
}

std::string element(std::uint16_t group, std::uint16_t number, const std::string& vr,
                    std::string value) {
  if (value.size() % 2 == 1) value += vr == "UI" ? '\0' : ' ';
  const std::string head = u16(group) + u16(number) + vr;
  if (vr == "OW" || vr == "OB" || vr == "SQ") {
    return head + std::string(2, '\0') + u32(static_cast<std::uint32_t>(value.size())) + value;
  }
  return head + u16(static_cast<std::uint16_t>(value.size())) + value;
}

/// A sequence of one item.
std::string sequence(std::uint16_t group, std::uint16_t number, const std::string& content) {
  return element(group, number, "SQ", item(content));
}

void write_part_10(const std::string& path, const std::string& data_set) {
  const std::string meta = element(2, 0x10, "UI", "1.2.840.10008.1.2.1");
  write_file(path, std::string(128, '\0') + "DICM" +
                       element(2, 0, "UL", u32(static_cast<std::uint32_t>(meta.size()))) + meta +
                       data_set);
}

}  // namespace

void write_dicom(const std::string& path, const DicomSample& s) {
  std::string set = element(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2") +
                    element(8, 0x60, "CS", s.modality) + element(0x10, 0x10, "PN", s.patient_name) +
                    element(0x20, 0x0e, "UI", s.series);
  if (s.position) set += element(0x20, 0x32, "DS", *s.position);
  if (s.position) set += element(0x20, 0x37, "DS", s.orientation);
  set += element(0x28, 0x02, "US", u16(s.samples)) + element(0x28, 0x04, "CS", s.photometric);
  if (s.samples > 1) set += element(0x28, 0x06, "US", u16(s.planar));
  set += element(0x28, 0x10, "US", u16(s.rows)) + element(0x28, 0x11, "US", u16(s.columns));
  if (!s.pixel_spacing.empty()) set += element(0x28, 0x30, "DS", s.pixel_spacing);
  if (s.frames > 1) set += element(0x28, 0x08, "IS", std::to_string(s.frames));
  if (s.padding) set += element(0x28, 0x120, "SS", bytes_of<std::int16_t>({*s.padding}));
  set += element(0x28, 0x100, "US", u16(s.bits_allocated)) +
         element(0x28, 0x101, "US", u16(s.bits_stored)) +
         element(0x28, 0x102, "US", u16(s.high_bit)) +
         element(0x28, 0x103, "US", u16(s.is_signed)) + element(0x28, 0x1052, "DS", s.intercept) +
         element(0x28, 0x1053, "DS", s.slope);
  const std::size_t bytes = std::size_t{s.rows} * s.columns * s.samples * s.bits_allocated / 8U;
  set += element(0x7fe0, 0x10, "OW", s.voxels.empty() ? std::string(bytes, '\0') : s.voxels);
  write_part_10(path, set);
}

void write_segmentation(const std::string& path, const SegmentationSample& s) {
  std::string segments;
  std::string frames;
  for (std::size_t i = 0; i < s.numbers.size(); ++i) {
    std::string segment = element(0x62, 0x04, "US", u16(s.numbers[i])) +
                          element(0x62, 0x05, "LO", "part " + std::to_string(s.numbers[i]));
    if (!s.colors.empty()) {
      const auto& [l, a, b] = s.colors[i];
      segment += element(0x62, 0x0d, "US", u16(l) + u16(a) + u16(b));
    }
    segments += item(segment);
  }
  for (std::size_t i = 0; i < s.positions.size(); ++i) {
    const std::uint16_t segment = s.segments.empty() ? 1 : s.segments[i];
    std::string frame = sequence(0x20, 0x9113, element(0x20, 0x32, "DS", s.positions[i]));
    if (s.labels.empty()) frame += sequence(0x62, 0x0a, element(0x62, 0x0b, "US", u16(segment)));
    frames += item(frame);
  }
  std::string packed((s.voxels.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < s.voxels.size(); ++i) {
    if (s.voxels[i]) packed[i / 8] = static_cast<char>(packed[i / 8] | 1 << i % 8);
  }
  const bool is_label_map = !s.labels.empty();
  const std::uint16_t bits = is_label_map ? s.label_bits : s.fractions.empty() ? 1 : 8;
  const std::string padding = s.padding ? element(0x28, 0x120, "US", u16(*s.padding)) : "";
  std::string more = s.fractions.empty() ? "" : element(0x62, 0x0e, "US", u16(200));
  std::string spacing = s.thickness.empty() ? "" : element(0x18, 0x50, "DS", s.thickness);
  if (!s.spacing.empty()) spacing += element(0x18, 0x88, "DS", s.spacing);
  if (!s.overlap.empty()) more += element(0x62, 0x13, "CS", s.overlap);
  const std::string sop_class = "1.2.840.10008.5.1.4.1.1.66.";
  write_part_10(
      path,
      element(8, 0x16, "UI", sop_class + (is_label_map ? "7" : "4")) +
          element(8, 0x60, "CS", "SEG") +
          element(0x20, 0x0e, "UI", "1.2.3") + element(0x28, 0x02, "US", u16(1)) +
          element(0x28, 0x04, "CS", "MONOCHROME2") +
          element(0x28, 0x08, "IS", std::to_string(s.positions.size())) +
          element(0x28, 0x10, "US", u16(3)) + element(0x28, 0x11, "US", u16(5)) +
          element(0x28, 0x100, "US", u16(bits)) + element(0x28, 0x101, "US", u16(bits)) +
          element(0x28, 0x102, "US", u16(static_cast<std::uint16_t>(bits - 1))) +
          element(0x28, 0x103, "US", u16(0)) + padding +
          element(0x62, 0x01, "CS", s.type) + element(0x62, 0x02, "SQ", segments) + more +
          sequence(0x5200, 0x9229,
                   sequence(0x20, 0x9116, element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")) +
                       sequence(0x28, 0x9110, spacing + element(0x28, 0x30, "DS", "0.5\\0.5"))) +
          element(0x5200, 0x9230, "SQ", frames) +
          element(0x7fe0, 0x10, bits == 16 ? "OW" : "OB",
                  is_label_map ? s.labels : s.fractions.empty() ? packed : s.fractions));
}

}  // namespace octavo::testing
