// The data set of a DICOM file, visited element by element and proven complete, without its voxels.
//
// The traversal depends on nothing but the file's bytes: every length is checked against the end of
// the file before it is used, so a cut file is found here and no decoder ever sees one. Pixel data
// are located, not read; encapsulated ones are visited fragment by fragment to their delimiter.
//
// Source: DICOM PS3.5 (7 Data Set, A.4 Encapsulation), PS3.10 (7 File Format)
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/io/dicom/dicom_inflated.h"

namespace octavo {

/// (group << 16) | element.
using DicomTag = std::uint32_t;

/// "(0028,0010)".
std::string dicom_tag_text(DicomTag tag);

/// The short values of one data set or item. Values longer than 512 bytes (64 KiB of a rescale and
/// of lists that speak of every frame, 128 KiB of color tables) and private groups are left out.
class DicomSet {
 public:
  bool has(DicomTag tag) const;
  /// Text without padding; empty when absent.
  std::string text(DicomTag tag) const;
  /// The backslash-separated numbers of a text value; empty when absent or not numbers.
  std::vector<double> decimals(DicomTag tag) const;
  std::optional<double> decimal(DicomTag tag) const;
  /// A binary unsigned value of 2 or 4 bytes.
  std::optional<std::int64_t> unsigned_value(DicomTag tag) const;
  /// The numbers of 16 bits that make up a binary value; none when it is absent or of odd length.
  std::vector<std::uint16_t> words(DicomTag tag) const;
  /// A binary float64; nothing where it is absent or not finite.
  std::optional<double> float64(DicomTag tag) const;
  /// The items of a sequence; none when absent.
  const std::vector<DicomSet>& items(DicomTag tag) const;

  void add_value(DicomTag tag, std::string bytes);
  void add_item(DicomTag tag, DicomSet item);
  void set_big_endian(bool big_endian) { big_endian_ = big_endian; }

 private:
  std::map<DicomTag, std::string> values_;
  std::map<DicomTag, std::vector<DicomSet>> sequences_;
  bool big_endian_ = false;
};

/// A run of bytes in a file.
struct ByteRun {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
};

/// Where the voxels stand.
struct DicomPixels {
  bool is_present = false;
  bool is_float = false;             ///< Float or Double Float Pixel Data
  bool is_words = false;             ///< of 16 bits each (VR OW), whatever a voxel takes
  bool is_encapsulated = false;
  ByteRun native;                    ///< of a plain value
  std::shared_ptr<InflatedFile> inflated;  ///< what `native` counts in; null: the file itself
  std::vector<std::uint64_t> frame_offsets;  ///< of the basic offset table, when it is there
  std::vector<ByteRun> fragments;    ///< encapsulated: without the basic offset table
  std::optional<std::size_t> picture_count;  ///< fragments that start a picture, once asked for
};

struct DicomFile {
  std::string path;
  std::string transfer_syntax;
  std::string media_class;  ///< Media Storage SOP Class UID, of the file meta information
  bool big_endian = false;
  DicomSet data;
  DicomPixels pixels;
  /// How often every element is there, in sequences as well; private groups are counted in one.
  std::map<DicomTag, std::int64_t> element_counts;
  std::int64_t private_count = 0;
  std::string siemens_header;  ///< the picture's CSA header, a private element; empty: none
};

/// True when the file starts as DICOM does: "DICM" behind a preamble, or a first element of group
/// 0002 or 0008 where there is no preamble. Throws Error{io}.
bool looks_like_dicom(const std::string& path);

/// Visits the whole file. Frames deflated one by one and private transfer syntaxes are rejected by
/// name.
/// Throws Error{source_rejected} naming the element where the file ends early or makes no sense;
/// Error{io}
DicomFile read_dicom_file(const std::string& path);

}  // namespace octavo
