// Small DICOM files.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace octavo::testing {

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

/// A DICOM segmentation of 5 x 3 voxels of 1 bit, with its geometry in functional groups; with
/// `labels` a label map.
struct SegmentationSample {
  std::string type = "BINARY";
  std::vector<std::string> positions;   ///< of each frame, "x\\y\\z"
  std::vector<std::uint16_t> segments;  ///< of each frame; empty: all of segment 1
  std::vector<bool> voxels;             ///< of all frames, one behind the other
  std::string fractions;                ///< instead of them 8 bits each, of at most 200
  std::string labels;                   ///< instead of them numbers of segments, native bytes
  std::uint16_t label_bits = 8;
  std::optional<std::uint16_t> padding; ///< Pixel Padding Value
  std::vector<std::uint16_t> numbers = {1, 2};  ///< of the segments, each "part N"
  std::vector<std::array<std::uint16_t, 3>> colors;  ///< of the segments, in CIELab; empty: none
  std::string overlap;                  ///< "YES", "NO" or nothing
  std::string spacing;                  ///< Spacing Between Slices
  std::string thickness;
};
void write_segmentation(const std::string& path, const SegmentationSample& sample);

}  // namespace octavo::testing
