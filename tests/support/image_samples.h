// Small TIFF and PNG files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace octavo::testing {

/// A tag that libtiff does not know; of `count` values.
struct TiffTag {
  std::uint32_t tag = 0;
  int type = 1;       ///< as TIFF counts: 1 bytes, 5 rationals (floats in `values`)
  std::uint32_t count = 0;
  std::string values; ///< native bytes
};

/// A single-page TIFF part: voxels of 8 or 16 bits.
struct TiffSample {
  std::uint32_t width = 4;
  std::uint32_t height = 3;
  std::uint16_t bits = 8;
  std::uint16_t format = 1;       ///< 1 unsigned, 2 signed, 3 float
  std::uint16_t samples = 1;      ///< 3 and more are written as RGB
  bool separate = false;          ///< samples in planes of their own, one behind the other
  std::uint16_t compression = 1;
  std::uint16_t predictor = 0;    ///< of codecs whose predictor libtiff writes; 0: none
  std::uint32_t tile = 0;         ///< side of tiles; 0: strips
  std::uint32_t rows_per_strip = 0;
  bool big = false;
  bool big_endian = false;        ///< the values in `pages` are native all the same
  std::string description;        ///< of each page
  std::vector<std::string> descriptions;    ///< of the pages instead; empty: none
  std::string further_description;          ///< a second ImageDescription of each page
  float resolution = 0;
  float y_resolution = 0;             ///< 0: that along x
  std::uint16_t resolution_unit = 1;  ///< 1 none, 2 inch, 3 cm
  std::vector<std::uint16_t> orientations;  ///< of the pages; empty: not written
  std::vector<bool> palettes;               ///< pages that have one; empty: none
  std::vector<TiffTag> tags;      ///< of each page
  std::uint32_t depth = 1;        ///< ImageDepth
  std::vector<std::string> pages; ///< native bytes
};
void write_tiff(const std::string& path, const TiffSample& sample);

/// Where a little-endian TIFF has the last entry of a tag of one number, or of one that lists some.
std::size_t entry_of(const std::string& bytes, std::uint16_t tag);
/// The number of that entry.
std::uint32_t number_of(const std::string& bytes, std::uint16_t tag);
/// Gives that tag another number, as LONG.
void set_number(std::string& bytes, std::uint16_t tag, std::uint32_t number);
/// Gives it several, behind all other bytes of the file.
void set_numbers(std::string& bytes, std::uint16_t tag, const std::vector<std::uint32_t>& numbers);

/// A PNG of 8 or 16 bits; color_type as libpng counts (0 grey, 2 RGB).
void write_png(const std::string& path, std::uint32_t width, std::uint32_t height, int bits,
               int color_type, const std::string& big_endian_rows);

}  // namespace octavo::testing
