// TIFF files out of planes, deflated strip by strip.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octavo/file/storage/storage.h"
#include "octavo/io/export/export_target.h"

namespace octavo {

/// The strips of a page, each deflated alone.
struct DeflatedPage {
  std::uint32_t rows_per_strip = 0;
  std::vector<ByteString> strips;
};

/// Deflates one plane on all threads of the arena; 8- and 16-bit samples with horizontal
/// differences.
DeflatedPage deflate_page(const ExportPlan& plan, std::span<const std::uint8_t> plane);

/// A TIFF file under construction in a file of the storage seam.
class TiffOutput {
 public:
  /// is_big  BigTIFF, for files that may pass 4 GB
  TiffOutput(StorageFile& file, bool is_big);
  ~TiffOutput();
  TiffOutput(const TiffOutput&) = delete;
  TiffOutput& operator=(const TiffOutput&) = delete;

  /// Appends a page; `description` may be empty. Throws Error{io}.
  void add_page(const ExportPlan& plan, const DeflatedPage& page, const std::string& description);
  /// Ends the file; it stays open in the seam. Throws Error{io}.
  void finish();

  class Handle;

 private:
  std::unique_ptr<Handle> handle_;
};

/// What a TIFF can say of geometry and rescale: ImageJ's text, read by Fiji among others.
/// page_count  pages of the file it goes into
std::string tiff_description(const ExportPlan& plan, std::int64_t page_count);

}  // namespace octavo
