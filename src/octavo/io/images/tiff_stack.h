// The pages of TIFF files that become the planes of a volume, and what they say of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/io/images/tiff_description.h"
#include "octavo/io/images/tiff_page.h"
#include "octavo/io/source/source_identity.h"
#include "octavo/io/source_options.h"

namespace octavo {

/// Where one plane stands.
struct TiffPlane {
  std::size_t file = 0;
  std::int64_t number = 0;  ///< of the page in its file, thumbnails counted
  TiffPage page;
  std::uint64_t data_offset = 0;  ///< of a plane that has no page of its own
};

/// Everything the pages say.
struct TiffStack {
  std::vector<std::string> files;
  std::vector<TiffPlane> planes;
  TiffDescription description;   ///< of the first plane's page
  std::optional<std::uint64_t> plain_run;  ///< start of that page's voxels, as in TiffFile
  double tag_x_mm = 0;           ///< pixels by the resolution tags of that page; 0: none
  double tag_y_mm = 0;
  bool is_big_endian = false;    ///< of the first file
  std::int64_t reduced_pages = 0;
  std::int64_t silent_files = 0; ///< without a size of voxels, where the first file has one
  std::string odd_resolution;    ///< the first file with other resolution tags than the first one
  std::string order_warning;     ///< why the order of files is not sure
  std::string count_warning;     ///< pages that the description does not tell of
  std::string series_warning;    ///< series beside the one that is taken
  std::int64_t sample = 0;       ///< the one of each pixel that is taken
  SourceIdentity identity;       ///< of all pages
};

/// Whether values have 1, 2 or 4 bits.
bool has_few_levels(const TiffPage& page);

/// "uint8", "uint8 of 1 bit", "RGB uint16 (white is 0)", "4 samples of uint8",
/// "uint8 (with a palette)".
std::string type_text(const TiffPage& page);

/// Bytes of a plane as it is stored.
std::uint64_t stored_bytes(const TiffPage& page);

/// Whether planes without a page may follow that of the one page of a file: huge stacks of ImageJ,
/// truncated ones of tifffile and those of MetaMorph are written so.
/// plain_run  where the voxels of the page start
bool may_hold(const TiffPage& page, std::optional<std::uint64_t> plain_run, std::int64_t planes,
              const std::string& path);

/// All pages of some files of one page each, or those of one file that are the series asked for;
/// thumbnails are left out. They have one size and one type.
/// Throws Error{source_rejected}, Error{invalid_argument} for a series that is not there, Error{io}
TiffStack examine_tiffs(std::vector<std::string> files, const SourceOptions& options);

}  // namespace octavo
