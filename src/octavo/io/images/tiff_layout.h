// Where the strips or tiles of a TIFF page stand, proven by its directory. libtiff fills lists that
// are too short with zeros, and takes the head of the file for voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "octavo/io/images/tiff_directory.h"

namespace octavo {

/// The blocks of a page: strips or tiles, plane after plane where samples stand apart.
struct TiffLayout {
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint64_t> byte_counts;  ///< empty in old files of one strip
  std::uint64_t absent_blocks = 0;         ///< of which nothing is stored: their values are 0
  std::uint64_t excess_bytes = 0;          ///< behind the rows of an uncompressed block, which has
                                           ///< more than these fill; of the first such block

  /// Whether nothing is stored of a block. libtiff counts a large strip as many.
  bool is_absent(std::size_t number) const {
    const std::size_t at = offsets.size() == 1 ? 0 : number;
    return at < byte_counts.size() && byte_counts[at] == 0 && offsets[at] == 0;
  }
};

/// Proves that each tag of one number has one, and that no other entry contradicts it.
/// Throws Error{source_rejected}, Error{io}
void require_single_numbers(const TiffDirectory& directory);

/// Directories of a file: the end of each by its begin.
using TiffDirectories = std::map<std::uint64_t, std::uint64_t>;

/// What of a page is known before its layout.
struct TiffPageBits {
  std::int64_t number = 0;  ///< of the page, for messages
  std::uint64_t sample_bits = 8;
  bool is_compressed = false;
};

/// Proves that there is a place for each strip or tile, none of them in the head of the file or in
/// a directory, and of uncompressed ones enough bytes. A block of 0 bytes at byte 0 is absent.
/// known     directories that no block may stand in
/// Requires  require_single_numbers
/// Throws    Error{source_rejected}, Error{io}
TiffLayout tiff_layout(const TiffDirectory& directory, const TiffPageBits& page,
                       const TiffDirectories& known);

}  // namespace octavo
