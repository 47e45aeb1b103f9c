// What microscopy programs write into a TIFF's description: ImageJ's lines and OME's XML.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/volume.h"

namespace octavo {

/// Counts are 0 and spacings absent where the description is silent.
struct TiffDescription {
  bool is_imagej = false;
  bool is_ome = false;
  std::int64_t channels = 0;
  std::int64_t frames = 0;   ///< points in time
  std::int64_t slices = 0;   ///< OME: planes of one channel and time
  std::string order;         ///< of pages: "CZT" where channels change fastest; OME has others
  std::int64_t images = 0;   ///< ImageJ: pages in all
  std::optional<Rescale> rescale;  ///< ImageJ: a calibration that is a straight line
  std::string value_unit;          ///< of calibrated values; empty where none is known
  bool has_other_function = false; ///< ImageJ: a calibration that is no straight line
  std::int64_t other_function = 0; ///< the number that ImageJ gives it
  std::string unknown_unit;        ///< of lengths; the spacings are absent then
  std::optional<double> x_mm;
  std::optional<double> y_mm;
  std::optional<double> z_mm;
};

/// x_resolution, y_resolution  pixels per unit from the tags; 0 when absent (ImageJ keeps x and y
/// there)
TiffDescription parse_tiff_description(const std::string& text, double x_resolution,
                                       double y_resolution);

}  // namespace octavo
