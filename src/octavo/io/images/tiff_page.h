// One page of a TIFF file: what its tags say, and its voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/io/images/tiff_block.h"
#include "octavo/io/images/tiff_layout.h"
#include "octavo/io/images/tiff_predictor.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/source/source_identity.h"
#include "octavo/io/source/stored_type.h"

struct tiff;

namespace octavo {

/// What a page holds, as far as planes need it.
struct TiffPage {
  std::uint64_t directory_offset = 0;
  std::int64_t width = 0;
  std::int64_t height = 0;
  StoredType type = VoxelType::uint8;
  int packed_bits = 0;            ///< of values in fewer bits (tiff_packed.h); 0: bytes are whole
  std::int64_t samples = 1;       ///< of each pixel: colors or channels
  bool is_separate = false;       ///< samples stand in planes of their own, else they alternate
  bool is_rgb = false;            ///< the first three samples are red, green and blue
  bool is_min_white = false;      ///< smaller values are brighter
  bool has_palette = false;       ///< values are numbers of colors
  bool is_reduced = false;        ///< a thumbnail of another page
  bool is_lossy = false;          ///< the compression may have changed values
  TiffPrediction prediction = TiffPrediction::none;  ///< that libtiff does not undo
  bool has_absent_blocks = false; ///< strips or tiles of which nothing is stored, read as 0
  std::uint64_t excess_bytes = 0; ///< behind the rows of an uncompressed strip or tile
  int orientation = 1;            ///< 1: first row at the top, first column at the left
};

/// An open TIFF file; silent, its messages go into errors. One thread at a time.
class TiffFile {
 public:
  /// Throws Error{io} when missing, Error{source_rejected} when libtiff cannot read it.
  explicit TiffFile(const std::string& path);
  ~TiffFile();
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  /// The page the file stands at. Throws Error{source_rejected} on color that is not RGB, a type
  /// that is no voxel type, and a directory that contradicts itself.
  TiffPage page();
  /// Goes from the page that page() gave to the next one; false behind the last one. Throws
  /// Error{source_rejected} on a damaged one, and where the last one leads back to one in front.
  bool next_page();
  /// Goes to the page at an offset. Throws Error{source_rejected}.
  /// number  of the page, for messages
  void go_to(std::uint64_t directory_offset, std::int64_t number);
  /// Decodes one sample of the current page, which page() gave: rows of `page.width` values of
  /// page.type in native order.
  /// Throws Error{source_rejected} when data are missing or damaged.
  void read_voxels(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane);

  /// Where the voxels of the current page start, if they are one plain run of bytes: uncompressed,
  /// of one sample, without gaps.
  std::optional<std::uint64_t> plain_run(const TiffPage& page) const;

  /// ImageDescription of the current page, or nothing.
  std::string image_description();
  /// Those that the current page has beside the first: tifffile's, where the user gave a text.
  std::vector<std::string> further_descriptions();
  /// The record of a Zeiss LSM file, as it stands in the current page; empty where there is none.
  std::vector<std::byte> lsm_record();
  /// Planes of a MetaMorph stack, by the current page; 0 where it is none.
  std::int64_t metamorph_planes();
  /// Adds the texts of the current page and the names of tags that are not of the picture.
  void note_identity(SourceIdentity& identity);
  /// Pixels per unit along x and y of the current page; 0 when the tag is absent.
  double x_resolution();
  double y_resolution();
  /// Millimeters of the unit that the resolution counts in; 0 where there is none.
  double resolution_unit_mm();
  bool is_big_endian();

 private:
  [[noreturn]] void reject(const std::string& why) const;
  /// Takes the blocks of the current page.
  void take_layout(const TiffDirectory& directory, std::uint64_t bits, std::uint16_t compression,
                   TiffPage& page);
  /// Of the current page.
  bool is_lossy(const StoredType& type, std::uint16_t compression) const;
  /// How the values of a strip or tile stand in its rows.
  /// row_pixels  of the tile, or of the page
  PredictedRows predicted_rows(const TiffPage& page, std::int64_t row_pixels);
  TiffBlockDecoder block_decoder(const TiffPage& page, const PredictedRows& layout);
  void read_strips(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane);
  void read_tiles(const TiffPage& page, std::int64_t sample, std::span<std::byte> plane);

  std::string path_;
  SourceFile file_;
  std::int64_t number_ = 0;  // of the current page
  TiffDirectories directories_;  // of the pages so far
  std::uint64_t link_ = 0;       // from the last page() to the next one
  TiffLayout layout_;            // of the last page()
  std::unique_ptr<TiffMessages> messages_;
  tiff* handle_ = nullptr;
};

}  // namespace octavo
