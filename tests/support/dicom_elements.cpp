#include "support/dicom_elements.h"

#include "support/source_files.h"

namespace octavo::testing {

std::string DicomElements::u16(std::uint32_t value) const {
  return bytes_of<std::uint16_t>({static_cast<std::uint16_t>(value)}, big_endian_);
}

std::string DicomElements::u32(std::uint32_t value) const {
  return bytes_of<std::uint32_t>({value}, big_endian_);
}

void DicomElements::set(std::uint32_t tag, const std::string& vr, const std::string& value) {
  std::string padded = value;
  const bool is_text = vr != "UI" && !vr.starts_with('O');
  if (padded.size() % 2 == 1) padded += is_text ? ' ' : '\0';
  const bool is_long = vr.starts_with('O') || vr == "SQ";
  const auto length = static_cast<std::uint32_t>(padded.size());
  elements_[tag] = tag_bytes(tag) + vr +
                   (is_long ? std::string(2, '\0') + u32(length) : u16(length)) + padded;
}

void DicomElements::set_number(std::uint32_t tag, std::uint16_t value) {
  set(tag, "US", u16(value));
}

void DicomElements::set_items(std::uint32_t tag, const std::vector<DicomElements>& items) {
  std::string all;
  for (const DicomElements& item : items) {
    const std::string content = item.bytes();
    all += tag_bytes(0xfffee000) + u32(static_cast<std::uint32_t>(content.size())) + content;
  }
  set(tag, "SQ", all);
}

void DicomElements::set_fragments(const std::vector<std::string>& fragments, bool has_table) {
  std::string table;
  std::string all;
  for (const std::string& fragment : fragments) {
    if (has_table) table += u32(static_cast<std::uint32_t>(all.size()));
    all += tag_bytes(0xfffee000) + u32(static_cast<std::uint32_t>(fragment.size())) + fragment;
  }
  elements_[kPixelData] = tag_bytes(kPixelData) + "OB" + std::string(2, '\0') + u32(0xffffffffU) +
                          tag_bytes(0xfffee000) + u32(static_cast<std::uint32_t>(table.size())) +
                          table + all + tag_bytes(0xfffee0dd) + u32(0);
}

std::string DicomElements::bytes() const {
  std::string all;
  for (const auto& [tag, element] : elements_) all += element;
  return all;
}

void DicomElements::write(const std::string& path, const std::string& transfer_syntax) const {
  DicomElements meta;
  meta.set(0x00020010, "UI", transfer_syntax);
  DicomElements length;
  const auto meta_bytes = static_cast<std::uint32_t>(meta.bytes().size());
  length.set(0x00020000, "UL", bytes_of<std::uint32_t>({meta_bytes}));
  write_file(path, std::string(128, '\0') + "DICM" + length.bytes() + meta.bytes() + bytes());
}

DicomElements ct_elements(std::uint16_t columns, std::uint16_t rows, std::uint16_t bits,
                          double z_mm, bool big_endian) {
  DicomElements all(big_endian);
  all.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.2");
  all.set(0x00080060, "CS", "CT");
  all.set(0x0020000e, "UI", "1.2.3");
  all.set(0x00200032, "DS", "0\\0\\" + std::to_string(z_mm));
  all.set(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
  all.set_number(0x00280002, 1);
  all.set(0x00280004, "CS", "MONOCHROME2");
  all.set_number(0x00280010, rows);
  all.set_number(0x00280011, columns);
  all.set(0x00280030, "DS", "0.5\\0.5");
  all.set_number(0x00280100, bits);
  all.set_number(0x00280101, bits);
  all.set_number(0x00280102, static_cast<std::uint16_t>(bits - 1));
  all.set_number(0x00280103, 0);
  const std::size_t pixel_bytes = (std::size_t{columns} * rows * bits + 7) / 8;
  all.set(0x7fe00010, bits > 8 ? "OW" : "OB", std::string(pixel_bytes, '\0'));
  return all;
}

}  // namespace octavo::testing
