// Which page of a TIFF is which slice, channel and point in time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/io/images/tiff_description.h"

namespace octavo {

/// Pages are slices x channels x times; samples that stand in one page count once.
struct PageCounts {
  std::int64_t channels = 1;
  std::int64_t slices = 1;
  std::int64_t times = 1;
};

/// How many pages lie between neighbors of each kind.
struct PageSteps {
  std::int64_t channel = 1;
  std::int64_t slice = 1;
  std::int64_t time = 1;
};

/// Steps of an order such as "CZT", of which the first changes fastest.
/// Throws Error{source_rejected} unless it names each of C, Z and T once; where there is one
///        channel and one time, any order will do.
PageSteps page_steps(const std::string& order, const PageCounts& counts, const std::string& path);

/// The page of each plane in the order of page_steps, as OME's TiffData elements say; empty where
/// there are none.
/// samples  of a page; OME counts them as channels
/// Throws   Error{source_rejected} when a plane has no page or several, or a page several planes
std::vector<std::int64_t> ome_page_order(const TiffDescription& text, const PageCounts& counts,
                                         std::int64_t samples, const std::string& path);

/// Throws Error{source_rejected} when OME says that planes of the one file at `path` stand in other
/// files, or that its description does.
void require_own_pages(const TiffDescription& text, const std::string& path);

/// Proves that files of one page each lie in the order of the slices that OME gives them.
/// Returns a warning, or nothing: where OME names no files, or none of these.
/// Throws Error{source_rejected} naming the odd file with both places
std::string check_file_order(const TiffDescription& text, const std::vector<std::string>& files);

}  // namespace octavo
