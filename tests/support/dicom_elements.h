// DICOM files of any header, element by element, for tests of what a header may say.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace octavo::testing {

// Tags that many tests set, (group << 16) | element.
inline constexpr std::uint32_t kIntercept = 0x00281052;  // the rescale's
inline constexpr std::uint32_t kSlope = 0x00281053;
inline constexpr std::uint32_t kPixelData = 0x7fe00010;

/// The explicit elements of a data set; setting one again replaces it.
class DicomElements {
 public:
  explicit DicomElements(bool big_endian = false) : big_endian_(big_endian) {}

  /// tag  (group << 16) | element
  void set(std::uint32_t tag, const std::string& vr, const std::string& value);
  void set_number(std::uint32_t tag, std::uint16_t value);
  void set_items(std::uint32_t tag, const std::vector<DicomElements>& items);
  /// Encapsulated pixel data with a basic offset table of all fragments, or an empty one.
  void set_fragments(const std::vector<std::string>& fragments, bool has_table);
  void remove(std::uint32_t tag) { elements_.erase(tag); }

  /// All elements in the order of their tags.
  std::string bytes() const;
  /// A file with these elements and file meta information.
  void write(const std::string& path, const std::string& transfer_syntax) const;

 private:
  std::string u16(std::uint32_t value) const;
  std::string u32(std::uint32_t value) const;
  std::string tag_bytes(std::uint32_t tag) const { return u16(tag >> 16) + u16(tag & 0xffffU); }

  bool big_endian_;
  std::map<std::uint32_t, std::string> elements_;
};

inline constexpr const char* kExplicitLittle = "1.2.840.10008.1.2.1";
inline constexpr const char* kExplicitBig = "1.2.840.10008.1.2.2";
inline constexpr const char* kRunLengths = "1.2.840.10008.1.2.5";
inline constexpr const char* kJpegBaseline = "1.2.840.10008.1.2.4.50";
inline constexpr const char* kJpegLs = "1.2.840.10008.1.2.4.80";
inline constexpr const char* kJpeg2000 = "1.2.840.10008.1.2.4.90";

/// A CT slice of columns x rows voxels of `bits` bits at the height `z_mm`, all of them 0, without
/// a rescale.
DicomElements ct_elements(std::uint16_t columns, std::uint16_t rows, std::uint16_t bits,
                          double z_mm = 0, bool big_endian = false);

}  // namespace octavo::testing
