#include "octavo/io/images/tiff_series.h"

#include <algorithm>

#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kMostSeriesListed = 4;

/// "3 planes in pages 0 to 2", "5 planes from page 3 on".
std::string series_text(std::int64_t page, std::int64_t pages, std::int64_t planes) {
  const std::string count = std::to_string(planes) + (planes == 1 ? " plane" : " planes");
  const std::string first = std::to_string(page);
  if (planes > pages) return count + " from page " + first + " on";
  if (pages == 1) return count + " in page " + first;
  return count + " in pages " + first + " to " + std::to_string(page + pages - 1);
}

}  // namespace

void TiffSeries::add(std::int64_t page, const TiffDescription& text) {
  const std::int64_t planes = std::max<std::int64_t>(text.images, 1);
  starts_.push_back({page, planes, !text.program.empty()});
  const bool has_all_pages = !text.is_truncated && planes < INT64_MAX - page;
  next_start_ = page + (has_all_pages ? planes : 1);
}

void TiffSeries::require_one(const std::string& path) const {
  const auto is_volume = [](const Start& start) { return start.planes > 1; };
  const auto volumes = std::count_if(starts_.begin(), starts_.end(), is_volume);
  const auto told = std::count_if(starts_.begin(), starts_.end(),
                                  [](const Start& start) { return start.is_told; });
  // What stands behind a single volume and is not told of is left to those who count its pages.
  if (volumes == 0 || (volumes == 1 && told == 1 && is_volume(starts_.front()))) return;
  std::vector<std::string> series;
  for (std::size_t i = 0; i < starts_.size();) {
    std::size_t end = i + 1;
    while (!is_volume(starts_[i]) && end < starts_.size() && !is_volume(starts_[end])) ++end;
    const auto pages = static_cast<std::int64_t>(end - i);
    series.push_back(series_text(starts_[i].page, pages,
                                 is_volume(starts_[i]) ? starts_[i].planes : pages));
    i = end;
  }
  std::string list;
  for (std::size_t i = 0; i < std::min(series.size(), kMostSeriesListed); ++i) {
    list += (i == 0 ? "" : ", ") + series[i];
  }
  if (series.size() > kMostSeriesListed) {
    list += " and " + std::to_string(series.size() - kMostSeriesListed) + " more";
  }
  reject(path, "it holds " + std::to_string(series.size()) + " series of pages (" + list +
                   ", by the descriptions in them), and a volume is made of one; save that as a "
                   "file of its own");
}

}  // namespace octavo
