#include "octavo/io/images/tiff_layout.h"

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <string>

#include "octavo/core/checked.h"

namespace octavo {

namespace {

/// The blocks that a page has by its size.
struct BlockGrid {
  std::string page;               ///< "page 0"
  bool has_tiles = false;
  std::uint64_t height = 0;       ///< of the page
  std::uint64_t row_bytes = 0;    ///< of a block
  std::uint64_t block_rows = 0;
  std::uint64_t stated_rows = 0;  ///< of a strip, maybe more than the page has
  std::uint64_t per_plane = 0;
  std::uint64_t count = 0;

  std::string name(std::size_t block) const {
    return (has_tiles ? "tile " : "strip ") + std::to_string(block) + " of " + page;
  }
  /// Rows that are stored; those of a tile go on behind the page.
  std::uint64_t rows_of(std::uint64_t block) const {
    if (has_tiles) return block_rows;
    return std::min(block_rows, height - block % per_plane * block_rows);
  }
  std::uint64_t bytes_of(std::uint64_t rows) const {
    return checked_mul(rows, row_bytes, "bytes of a block");
  }
};

std::uint64_t blocks_over(std::uint64_t whole, std::uint64_t part) {
  return whole / part + (whole % part != 0 ? 1 : 0);
}

BlockGrid block_grid(const TiffDirectory& directory, std::uint64_t bits) {
  const auto number = [&](std::uint16_t tag, std::uint64_t absent) {
    return std::max<std::uint64_t>(directory.number(tag).value_or(absent), 1);
  };
  constexpr std::uint64_t kAllRows = std::numeric_limits<std::uint32_t>::max();
  const std::uint64_t samples = number(TIFFTAG_SAMPLESPERPIXEL, 1);
  const bool are_apart = number(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == PLANARCONFIG_SEPARATE;
  const std::uint64_t width = number(TIFFTAG_IMAGEWIDTH, 1);
  BlockGrid grid;
  grid.height = number(TIFFTAG_IMAGELENGTH, 1);
  grid.has_tiles = directory.has(TIFFTAG_TILEWIDTH) || directory.has(TIFFTAG_TILELENGTH);
  const std::uint64_t row_pixels = grid.has_tiles ? number(TIFFTAG_TILEWIDTH, 1) : width;
  const std::uint64_t rows =
      grid.has_tiles ? number(TIFFTAG_TILELENGTH, 1) : number(TIFFTAG_ROWSPERSTRIP, kAllRows);
  grid.block_rows = grid.has_tiles ? rows : std::min(rows, grid.height);
  grid.stated_rows = rows == kAllRows ? grid.block_rows : rows;
  const std::uint64_t row_values = checked_mul(row_pixels, are_apart ? 1 : samples, "row");
  grid.row_bytes = blocks_over(checked_mul(row_values, bits, "row"), 8);
  const std::uint64_t columns = blocks_over(width, row_pixels);
  grid.per_plane = checked_mul(columns, blocks_over(grid.height, grid.block_rows), "blocks");
  grid.count = checked_mul(grid.per_plane, are_apart ? samples : 1, "blocks");
  return grid;
}

/// A list of the directory, with a number for each block; empty where there is none.
std::vector<std::uint64_t> list_of(const TiffDirectory& directory, const BlockGrid& grid,
                                   std::uint16_t strip_tag, std::uint16_t tile_tag) {
  if (directory.has(strip_tag) && directory.has(tile_tag)) {
    reject(directory.file().path(),
           grid.page + " lists both strips and tiles; save it again with another program");
  }
  const std::uint16_t tag = directory.has(tile_tag) ? tile_tag : strip_tag;
  if (!directory.has(tag)) return {};
  const std::uint64_t listed = *directory.value_count(tag);
  // These programs may list the blocks of planes that have no page, too.
  const bool may_list_more = directory.has(kZeissTag) || directory.has(kMetaMorphTag);
  if (listed != grid.count && !(may_list_more && listed > grid.count)) {
    reject(directory.file().path(), grid.page + " has " + std::to_string(grid.count) +
                            (grid.has_tiles ? " tiles" : " strips") + " by its size, and tag " +
                            std::to_string(tag) + " lists " + std::to_string(listed) +
                            "; copy the file again from its origin");
  }
  return directory.numbers(tag, grid.count);
}

/// Proves the place of a block that is there.
/// needed  bytes from its offset on
void require_place(const TiffDirectory& directory, const TiffDirectories& known,
                   const std::string& block, std::uint64_t offset, std::uint64_t needed) {
  const std::uint64_t head_bytes = directory.is_big_tiff() ? 16 : 8;
  const std::string begins = block + " begins at byte " + std::to_string(offset);
  if (offset < head_bytes) {
    reject(directory.file().path(),
           begins + ", in the head of the file; copy it again from its origin");
  }
  const auto behind = known.lower_bound(checked_add(offset, needed, "end of a block"));
  if (behind == known.begin() || std::prev(behind)->second <= offset) return;
  reject(directory.file().path(), begins + " and has " + std::to_string(needed) +
                                      " or more, and a directory stands at byte " +
                                      std::to_string(std::prev(behind)->first) +
                                      "; copy the file again from its origin");
}

}  // namespace

void require_single_numbers(const TiffDirectory& directory) {
  constexpr std::array<std::uint16_t, 14> kSingle = {
      TIFFTAG_SUBFILETYPE, TIFFTAG_IMAGEWIDTH,   TIFFTAG_IMAGELENGTH,     TIFFTAG_PHOTOMETRIC,
      TIFFTAG_FILLORDER,   TIFFTAG_ORIENTATION,  TIFFTAG_SAMPLESPERPIXEL, TIFFTAG_ROWSPERSTRIP,
      TIFFTAG_PREDICTOR,   TIFFTAG_PLANARCONFIG, TIFFTAG_TILEWIDTH,       TIFFTAG_TILELENGTH,
      TIFFTAG_IMAGEDEPTH,  TIFFTAG_TILEDEPTH};
  for (const std::uint16_t tag : kSingle) directory.number(tag);
  // One number, or one for each sample: libtiff proves that these are alike.
  constexpr std::array<std::uint16_t, 3> kOfSamples = {
      TIFFTAG_BITSPERSAMPLE, TIFFTAG_COMPRESSION, TIFFTAG_SAMPLEFORMAT};
  constexpr std::uint64_t kMostSamples = 65535;
  for (const std::uint16_t tag : kOfSamples) directory.numbers(tag, kMostSamples);
}

TiffLayout tiff_layout(const TiffDirectory& directory, const TiffPageBits& page,
                       const TiffDirectories& known) {
  // Some programs round a block up to an even number of bytes, or to a multiple of four.
  constexpr std::uint64_t kMostFill = 3;
  BlockGrid grid = block_grid(directory, page.sample_bits);
  grid.page = "page " + std::to_string(page.number);
  TiffLayout layout;
  layout.offsets = list_of(directory, grid, TIFFTAG_STRIPOFFSETS, TIFFTAG_TILEOFFSETS);
  layout.byte_counts = list_of(directory, grid, TIFFTAG_STRIPBYTECOUNTS, TIFFTAG_TILEBYTECOUNTS);
  for (std::size_t i = 0; i < layout.offsets.size(); ++i) {
    if (layout.is_absent(i)) {
      ++layout.absent_blocks;
      continue;
    }
    const std::uint64_t rows = grid.rows_of(i);
    const std::uint64_t needed = page.is_compressed ? 1 : grid.bytes_of(rows);
    const bool has_count = !page.is_compressed && !layout.byte_counts.empty();
    const std::uint64_t found = has_count ? layout.byte_counts[i] : needed;
    if (found < needed) {
      reject(directory.file().path(),
             grid.name(i) + " has " + std::to_string(found) +
                 (found == 1 ? " byte" : " bytes") + ", and its " + std::to_string(rows) +
                 " rows need " + std::to_string(needed) +
                 "; copy the file again from its origin");
    }
    require_place(directory, known, grid.name(i), layout.offsets[i], needed);
    if (!has_count) continue;
    // Others fill the last strip with rows behind the page.
    const std::uint64_t most = grid.bytes_of(std::max(rows, grid.stated_rows));
    if (layout.excess_bytes == 0 && found > checked_add(most, kMostFill, "bytes of a block")) {
      layout.excess_bytes = found - needed;
    }
  }
  return layout;
}

}  // namespace octavo
