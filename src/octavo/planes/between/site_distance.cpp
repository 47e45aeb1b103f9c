#include "octavo/planes/between/site_distance.h"

namespace octavo {

namespace {

std::int64_t squared(std::int64_t value) { return value * value; }

}  // namespace

bool RowEnvelope::find(std::span<const std::int64_t> height_squared,
                       std::span<std::int32_t> nearest) {
  const auto count = static_cast<std::int32_t>(height_squared.size());
  const auto at = [&](std::int32_t x, std::int32_t k) {
    return squared(x - k) + height_squared[static_cast<std::size_t>(k)];
  };
  apex_.clear();
  start_.clear();
  // From left to right: each parabola ends those that it lies below from their start on.
  for (std::int32_t k = 0; k < count; ++k) {
    const std::int64_t height = height_squared[static_cast<std::size_t>(k)];
    if (height == kNoSite) continue;
    while (!apex_.empty() && at(start_.back(), apex_.back()) > at(start_.back(), k)) {
      apex_.pop_back();
      start_.pop_back();
    }
    if (apex_.empty()) {
      apex_.push_back(k);
      start_.push_back(0);
      continue;
    }
    const std::int32_t last = apex_.back();
    const std::int64_t rise = squared(k) - squared(last) + height -
                              height_squared[static_cast<std::size_t>(last)];
    const std::int64_t start = rise / (2 * (std::int64_t{k} - last)) + 1;
    if (start >= count) continue;
    apex_.push_back(k);
    start_.push_back(static_cast<std::int32_t>(start));
  }
  if (apex_.empty()) return false;
  // From right to left: what each of them is the lowest of.
  std::size_t parabola = apex_.size() - 1;
  for (std::int32_t x = count - 1; x >= 0; --x) {
    while (parabola > 0 && start_[parabola] > x) --parabola;
    nearest[static_cast<std::size_t>(x)] = apex_[parabola];
  }
  return true;
}

SiteDistance::SiteDistance(std::int64_t columns, std::int64_t rows)
    : columns_(static_cast<std::size_t>(columns)),
      rows_(static_cast<std::size_t>(rows)),
      site_row_(columns_ * rows_),
      heights_(columns_),
      nearest_(columns_) {}

bool SiteDistance::mark(std::span<const std::uint8_t> is_site) {
  bool is_any = false;
  // Downwards: the last site above, or here.
  for (std::size_t y = 0; y < rows_; ++y) {
    for (std::size_t x = 0; x < columns_; ++x) {
      const std::size_t i = y * columns_ + x;
      const std::int32_t above = y == 0 ? static_cast<std::int32_t>(kNoSite)
                                        : site_row_[i - columns_];
      site_row_[i] = is_site[i] != 0 ? static_cast<std::int32_t>(y) : above;
      is_any = is_any || is_site[i] != 0;
    }
  }
  // Upwards: the next one below where it is nearer.
  for (std::size_t y = rows_ - 1; y-- > 0;) {
    for (std::size_t x = 0; x < columns_; ++x) {
      const std::size_t i = y * columns_ + x;
      const std::int32_t below = site_row_[i + columns_];
      const auto here = static_cast<std::int32_t>(y);
      if (below > here && (site_row_[i] == kNoSite || below - here < here - site_row_[i])) {
        site_row_[i] = below;
      }
    }
  }
  return is_any;
}

void SiteDistance::measure_row(std::int64_t y, std::span<Nearest> row) {
  const std::int32_t* sites = site_row_.data() + static_cast<std::size_t>(y) * columns_;
  for (std::size_t x = 0; x < columns_; ++x) {
    heights_[x] = sites[x] == kNoSite ? kNoSite : squared(sites[x] - y);
  }
  envelope_.find(heights_, nearest_);
  for (std::size_t x = 0; x < columns_; ++x) {
    const auto k = static_cast<std::size_t>(nearest_[x]);
    row[x] = {squared(static_cast<std::int64_t>(x) - nearest_[x]) + heights_[k],
              static_cast<std::int64_t>(static_cast<std::size_t>(sites[k]) * columns_ + k)};
  }
}

}  // namespace octavo
