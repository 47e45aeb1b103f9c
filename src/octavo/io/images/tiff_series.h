// The series of pages in one TIFF file, of which a volume is one.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/io/images/tiff_description.h"
#include "octavo/io/images/tiff_page.h"

namespace octavo {

/// Pages that belong together.
struct TiffSeries {
  std::int64_t page = 0;    ///< the first one, thumbnails not counted
  std::int64_t pages = 1;
  std::int64_t planes = 1;  ///< more than pages where the rest stand behind the last one
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::string name;         ///< OME's, of a series that has its pages anywhere
  bool is_of_ome = false;
};

/// Finds series page by page. A description in a page speaks of that page and those behind it, as
/// many as it has planes; where the array is truncated, of its page alone. Pages that no such
/// description tells of are one series while they are alike.
class TiffSeriesFinder {
 public:
  /// Whether the page is none of a series that a description before it tells of.
  bool is_start(std::int64_t page) const { return page >= next_start_; }
  /// Takes what a page that is a start says. Requires growing numbers of pages.
  void add(std::int64_t number, const TiffPage& page, const TiffDescription& text);
  /// Whether all pages are one stack: saved one by one, or with an only description of several
  /// planes in the first one. What stands behind these is left to those who count pages.
  bool is_one() const;
  /// The series in a file of so many pages.
  std::vector<TiffSeries> found(std::int64_t page_count) const;

 private:
  struct Start {
    std::int64_t page = 0;
    std::int64_t planes = 1;
    std::int64_t width = 0;
    std::int64_t height = 0;
    StoredType type = VoxelType::uint8;
    bool is_told = false;  ///< by a description, else the page has none

    bool is_volume() const { return planes > 1; }
  };

  std::vector<Start> starts_;
  std::int64_t next_start_ = 0;
};

/// Which of the series is taken, by its number. Where none is asked for it is an only one of
/// several planes, where all others are single pictures smaller than it.
/// series   what was asked for; or nothing
/// warning  becomes what was left out
/// Throws   Error{source_rejected} that lists them, Error{invalid_argument} for no number of these
std::size_t choose_tiff_series(const std::vector<TiffSeries>& found, const std::string& series,
                               const std::string& path, std::string& warning);

}  // namespace octavo
