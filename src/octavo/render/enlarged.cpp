#include "octavo/render/enlarged.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace octavo {

namespace {

/// The two pixels beside a place and the share of the second.
struct BesidePixels {
  std::int64_t first = 0;
  std::int64_t second = 0;
  double share = 0;
};

std::vector<BesidePixels> beside_pixels(std::int64_t count, std::int64_t small_count, int by) {
  std::vector<BesidePixels> all;
  for (std::int64_t i = 0; i < count; ++i) {
    // The middles of both pictures are one place.
    const double at = (static_cast<double>(i) + 0.5 - static_cast<double>(count) / 2) / by +
                      static_cast<double>(small_count) / 2 - 0.5;
    const auto first = static_cast<std::int64_t>(std::floor(at));
    all.push_back({std::clamp<std::int64_t>(first, 0, small_count - 1),
                   std::clamp<std::int64_t>(first + 1, 0, small_count - 1),
                   at - static_cast<double>(first)});
  }
  return all;
}

}  // namespace

Picture enlarged(const Picture& small, std::int64_t width, std::int64_t height, int by) {
  Picture large = make_picture(width, height, small.channels);
  const std::vector<BesidePixels> columns = beside_pixels(width, small.width, by);
  const std::vector<BesidePixels> rows = beside_pixels(height, small.height, by);
  std::uint8_t* to = large.pixels.data();
  for (const BesidePixels& row : rows) {
    for (const BesidePixels& column : columns) {
      for (int channel = 0; channel < small.channels; ++channel) {
        const auto at = [&](std::int64_t x, std::int64_t y) {
          const std::int64_t place = (y * small.width + x) * small.channels + channel;
          return static_cast<double>(small.pixels[static_cast<std::size_t>(place)]);
        };
        const auto of_row = [&](std::int64_t y) {
          return std::lerp(at(column.first, y), at(column.second, y), column.share);
        };
        const double mixed = std::lerp(of_row(row.first), of_row(row.second), row.share);
        *to++ = static_cast<std::uint8_t>(std::lround(mixed));
      }
    }
  }
  return large;
}

}  // namespace octavo
