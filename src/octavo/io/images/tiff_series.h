// Whether the pages of one TIFF file are one stack, as the descriptions among them say.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/io/images/tiff_description.h"

namespace octavo {

/// The series of pages in a file, found page by page. A description in a page speaks of that page
/// and those behind it, as many as it has planes; where the array is truncated, of its page alone.
class TiffSeries {
 public:
  /// Whether the page is none of a series that a description before it tells of.
  bool is_start(std::int64_t page) const { return page >= next_start_; }
  /// Takes what a page that is a start says. Requires growing numbers of pages.
  void add(std::int64_t page, const TiffDescription& text);
  /// Pages that were saved one by one are one series, too.
  /// Throws Error{source_rejected} that lists the series where there are several
  void require_one(const std::string& path) const;

 private:
  struct Start {
    std::int64_t page = 0;
    std::int64_t planes = 1;
    bool is_told = false;  ///< by a description, else the page has none
  };

  std::vector<Start> starts_;
  std::int64_t next_start_ = 0;
};

}  // namespace octavo
