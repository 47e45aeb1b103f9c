// Small source files of every format, written into a folder that vanishes, and what was read from
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/open_source.h"

namespace octavo::testing {

/// A folder of its own, removed with all it holds.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const std::string& path() const { return path_; }
  std::string file(const std::string& name) const;  ///< makes the folders of `name`

 private:
  std::string path_;
};

bool contains(const std::string& text, const std::string& part);

void write_file(const std::string& path, const std::string& bytes);
std::string read_file(const std::string& path);
std::string gzip(const std::string& bytes);

/// The bytes of values, in either order.
template <class T>
std::string bytes_of(const std::vector<T>& values, bool big_endian = false) {
  std::string bytes;
  for (const T& value : values) {
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) bytes += raw[big_endian ? sizeof(T) - 1 - i : i];
  }
  return bytes;
}

/// All planes of a source as one byte string, native order.
std::string voxels_of(PlaneSource& source);

/// The error of `action`, which must throw octavo::Error.
Error error_of(const std::function<void()>& action);
/// The error of opening `paths` and reading every plane.
Error source_error(const std::vector<std::string>& paths, const SourceOptions& options = {});

/// One DICOM slice, explicit little-endian; absent fields are not written.
struct DicomSample {
  std::string series = "1.2.3";
  std::string modality = "CT";
  std::uint16_t columns = 4;
  std::uint16_t rows = 3;
  std::uint16_t bits_allocated = 16;
  std::uint16_t bits_stored = 16;
  std::uint16_t high_bit = 15;
  std::uint16_t is_signed = 1;
  std::uint16_t samples = 1;
  std::uint16_t planar = 0;                 ///< 1: samples stand in planes of their own
  std::string photometric = "MONOCHROME2";
  std::optional<std::string> position;      ///< "x\\y\\z"
  std::string orientation = "1\\0\\0\\0\\1\\0";
  std::string pixel_spacing = "0.5\\0.25";  ///< rows, then columns
  std::string slope = "1";
  std::string intercept = "-1024";
  std::string patient_name = "Nobody^Nemo";
  std::optional<std::int16_t> padding;
  int frames = 1;
  std::string voxels;                       ///< native bytes; empty: zeros
};
void write_dicom(const std::string& path, const DicomSample& sample);

/// A DICOM segmentation of 5 x 3 voxels of 1 bit, with its geometry in functional groups.
struct SegmentationSample {
  std::string type = "BINARY";
  std::vector<std::string> positions;   ///< of each frame, "x\\y\\z"
  std::vector<std::uint16_t> segments;  ///< of each frame; empty: all of segment 1
  std::vector<bool> voxels;             ///< of all frames, one behind the other
  std::string fractions;                ///< instead of them 8 bits each, of at most 200
  std::string overlap;                  ///< "YES", "NO" or nothing
};
void write_segmentation(const std::string& path, const SegmentationSample& sample);

/// A single-page TIFF part: voxels of 8 or 16 bits.
struct TiffSample {
  std::uint32_t width = 4;
  std::uint32_t height = 3;
  std::uint16_t bits = 8;
  std::uint16_t format = 1;       ///< 1 unsigned, 2 signed, 3 float
  std::uint16_t samples = 1;      ///< 3 and more are written as RGB
  bool separate = false;          ///< samples in planes of their own, one behind the other
  std::uint16_t compression = 1;
  std::uint32_t tile = 0;         ///< side of tiles; 0: strips
  std::uint32_t rows_per_strip = 0;
  bool big = false;
  std::string description;
  float resolution = 0;
  float y_resolution = 0;             ///< 0: that along x
  std::uint16_t resolution_unit = 1;  ///< 1 none, 2 inch, 3 cm
  std::vector<std::uint16_t> orientations;  ///< of the pages; empty: not written
  std::vector<bool> palettes;               ///< pages that have one; empty: none
  std::vector<std::string> pages; ///< native bytes
};
void write_tiff(const std::string& path, const TiffSample& sample);

/// A PNG of 8 or 16 bits; color_type as libpng counts (0 grey, 2 RGB).
void write_png(const std::string& path, std::uint32_t width, std::uint32_t height, int bits,
               int color_type, const std::string& big_endian_rows);

/// A NIfTI-1 header of 352 bytes with the voxel offset 352.
struct NiftiSample {
  std::vector<std::int16_t> size = {4, 3, 2};
  std::int16_t datatype = 4;
  std::int16_t bits = 16;
  bool big_endian = false;
  float slope = 0;
  float intercept = 0;
  std::array<float, 12> srow = {2, 0, 0, 10, 0, 3, 0, 20, 0, 0, 4, 30};
  std::int16_t sform = 1;
  std::int16_t intent = 0;
};
std::string nifti_header(const NiftiSample& sample);

}  // namespace octavo::testing
