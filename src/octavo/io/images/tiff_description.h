// What microscopy programs write of a TIFF: ImageJ's lines, OME's XML and the notes of others.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/volume.h"

namespace octavo {

/// Pages of a file that follow each other, and which planes they are: a TiffData element of OME.
/// Numbers count from 0; -1 stands for a text that is none.
struct OmePages {
  std::optional<std::int64_t> page;   ///< the first of them
  std::optional<std::int64_t> count;
  std::int64_t slice = 0;             ///< the first of the planes, then on in the order of pages
  std::int64_t channel = 0;
  std::int64_t time = 0;
  std::string file_name;              ///< of the file they stand in; empty: this file
  std::string file_id;                ///< its UUID

  /// How many of `total` pages: all where nothing says more, one where only the first is named.
  std::int64_t pages_of(std::int64_t total) const { return count.value_or(page ? 1 : total); }
};

/// One of the images that an OME description has.
struct OmeTiffImage {
  std::string name;
  std::int64_t planes = 1;
  std::int64_t width = 0;
  std::int64_t height = 0;
};

/// Counts are 0 and spacings absent where the description is silent.
struct TiffDescription {
  bool is_imagej = false;
  std::string program;       ///< whose description it is, for messages; empty: nobody's
  bool counts_samples = false; ///< the samples of a page are channels, too
  std::int64_t channels = 0;
  std::int64_t frames = 0;   ///< points in time
  std::int64_t slices = 0;   ///< planes of one channel and time
  std::string order;         ///< of pages: "CZT" where channels change fastest; OME has others
  std::int64_t images = 0;   ///< planes in all, with those that have no page; OME: 0
  bool is_truncated = false; ///< these have one page, of the first plane
  std::optional<Rescale> rescale;  ///< ImageJ: a calibration that is a straight line; or our note
  std::string value_unit;          ///< of calibrated values; empty where none is known
  bool has_other_function = false; ///< ImageJ: a calibration that is no straight line
  std::int64_t other_function = 0; ///< the number that ImageJ gives it
  std::string unknown_unit;        ///< of lengths; the spacings are absent then
  std::optional<double> x_mm;
  std::optional<double> y_mm;
  std::optional<double> z_mm;
  std::optional<Point3> origin_mm;  ///< of the center of the first voxel, noted by our exports
  std::optional<std::array<double, 9>> direction;  ///< as in Geometry, noted by our exports
  bool is_place_known = false;  ///< these two lead to places in a body
  std::int64_t columns = 0;  ///< OME: of each plane
  std::int64_t rows = 0;
  std::string voxel_type;    ///< OME: "uint16", "float32"; empty where the description is silent
  std::vector<OmeTiffImage> ome_images;
  std::vector<OmePages> ome_pages; ///< of the image read; empty until read_ome_pages
  std::string file_id;             ///< OME: the UUID of this file
  std::string damage;              ///< OME: what is wrong with its XML; empty where it is whole
  std::string metadata_file;       ///< OME: the file that has the description instead
};

/// x_resolution, y_resolution  pixels per unit from the tags; 0 when absent (ImageJ keeps x and y
/// there)
/// ome_image  which of the images that OME's description has
TiffDescription parse_tiff_description(const std::string& text, double x_resolution,
                                       double y_resolution, std::size_t ome_image);

}  // namespace octavo
