#include "octavo/io/images/tiff_series.h"

#include <algorithm>
#include <charconv>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/source/component_choice.h"

namespace octavo {

namespace {

constexpr std::size_t kMostSeriesListed = 8;

/// "3 planes of 512 x 512 in pages 0 to 2", "5 planes of 8 x 8 from page 3 on".
std::string series_text(const TiffSeries& series) {
  const std::string text = (series.name.empty() ? "" : "\"" + escaped(series.name) + "\", ") +
                           counted_text(series.planes, "plane") + " of " +
                           size_text(series.width, series.height);
  if (series.is_of_ome) return text;
  const std::string first = std::to_string(series.page);
  if (series.planes > series.pages) return text + " from page " + first + " on";
  if (series.pages == 1) return text + " in page " + first;
  return text + " in pages " + first + " to " + std::to_string(series.page + series.pages - 1);
}

std::string list_text(const std::vector<TiffSeries>& found) {
  std::string list;
  for (std::size_t i = 0; i < std::min(found.size(), kMostSeriesListed); ++i) {
    list += (i == 0 ? "" : "; ") + std::to_string(i) + ": " + series_text(found[i]);
  }
  if (found.size() > kMostSeriesListed) {
    list += " and " + std::to_string(found.size() - kMostSeriesListed) + " more";
  }
  return list;
}

/// The only series of several planes, where all others are smaller pictures; or found.size().
std::size_t beside_thumbnails(const std::vector<TiffSeries>& found) {
  const auto is_volume = [](const TiffSeries& series) { return series.planes > 1; };
  const auto volume = std::ranges::find_if(found, is_volume);
  const bool is_only = std::ranges::count_if(found, is_volume) == 1;
  const bool is_larger = is_only && std::ranges::all_of(found, [&](const TiffSeries& series) {
    return is_volume(series) || (series.width < volume->width && series.height < volume->height);
  });
  return is_larger ? static_cast<std::size_t>(volume - found.begin()) : found.size();
}

}  // namespace

void TiffSeriesFinder::add(std::int64_t number, const TiffPage& page, const TiffDescription& text) {
  const std::int64_t planes = std::max<std::int64_t>(text.images, 1);
  starts_.push_back({number, planes, page.width, page.height, page.type, !text.program.empty()});
  const bool has_all_pages = !text.is_truncated && planes < INT64_MAX - number;
  next_start_ = number + (has_all_pages ? planes : 1);
}

bool TiffSeriesFinder::is_one() const {
  const auto volumes = std::ranges::count_if(starts_, &Start::is_volume);
  const auto told = std::ranges::count_if(starts_, &Start::is_told);
  return volumes == 0 || (volumes == 1 && told == 1 && starts_.front().is_volume());
}

std::vector<TiffSeries> TiffSeriesFinder::found(std::int64_t page_count) const {
  std::vector<TiffSeries> found;
  for (std::size_t i = 0; i < starts_.size();) {
    const Start& first = starts_[i];
    const auto goes_on = [&](const Start& start) {
      return !first.is_volume() && !start.is_volume() && start.width == first.width &&
             start.height == first.height && start.type == first.type;
    };
    std::size_t end = i + 1;
    while (end < starts_.size() && goes_on(starts_[end])) ++end;
    TiffSeries series;
    series.page = first.page;
    series.pages = (end < starts_.size() ? starts_[end].page : page_count) - first.page;
    series.planes = first.is_volume() ? first.planes : series.pages;
    series.width = first.width;
    series.height = first.height;
    found.push_back(series);
    i = end;
  }
  return found;
}

std::size_t choose_tiff_series(const std::vector<TiffSeries>& found, const std::string& series,
                               const std::string& path, std::string& warning) {
  const auto count = static_cast<std::int64_t>(found.size());
  const std::string numbers = count > 1 ? numbers_to_give(count) : "";
  if (!series.empty()) {
    std::size_t number = 0;
    const auto [end, failure] =
        std::from_chars(series.data(), series.data() + series.size(), number);
    const bool is_number = failure == std::errc() && end == series.data() + series.size();
    if (is_number && number < found.size()) return number;
    throw Error(ErrorKind::invalid_argument,
                "series " + escaped(series) + " is not there: the file has " + list_text(found),
                path)
        .with_field("series", numbers);
  }
  if (found.size() == 1) return 0;
  const std::size_t volume = beside_thumbnails(found);
  if (volume == found.size()) {
    throw Error(ErrorKind::source_rejected,
                "it holds " + std::to_string(count) + " series of pages (" +
                    list_text(found) + "), and a volume is made of one",
                path)
        .with_field("series", numbers);
  }
  std::vector<TiffSeries> others = found;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(volume));
  warning = counted_text(static_cast<std::int64_t>(others.size()), "smaller picture") +
            " beside the volume left out (" + series_text(others.front()) +
            (others.size() > 1 ? " ..." : "") + ")";
  return volume;
}

}  // namespace octavo
