// The nearest site of every pixel of a plane: the exact Euclidean distance transform.
//
// Along columns first, then along rows by the lower envelope of parabolas: time linear in the
// pixels, in whole numbers throughout.
//
// Source: Meijster, Roerdink, Hesselink, "A general algorithm for computing distance transforms in
// linear time" (2000); Felzenszwalb, Huttenlocher, "Distance transforms of sampled functions"
// (2012)
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

/// A height that stands for "no site in this column".
inline constexpr std::int64_t kNoSite = -1;

/// The lower envelope of the parabolas (x - k)^2 + height_squared[k].
class RowEnvelope {
 public:
  /// Fills nearest[x] with the k of the lowest parabola at x, the leftmost of several.
  /// height_squared  kNoSite where there is no parabola; `nearest` is as long
  /// Returns false, and leaves `nearest` alone, when there is none at all. Time linear.
  bool find(std::span<const std::int64_t> height_squared, std::span<std::int32_t> nearest);

 private:
  std::vector<std::int32_t> apex_;
  std::vector<std::int32_t> start_;
};

/// Distances to marked pixels.
/// Memory  4 bytes a pixel
class SiteDistance {
 public:
  /// columns, rows  of the planes; fewer than 2^31 each
  SiteDistance(std::int64_t columns, std::int64_t rows);

  /// Takes the marked pixels ([y][x], not 0) as sites. False when there is none.
  bool mark(std::span<const std::uint8_t> is_site);

  struct Nearest {
    std::int64_t squared = 0;  ///< distance to it, in pixels
    std::int64_t index = 0;    ///< of it in the plane
  };

  /// Fills `row` (one entry a column) with the nearest sites of the pixels of row y.
  /// Requires that there is a site.
  void measure_row(std::int64_t y, std::span<Nearest> row);

 private:
  std::size_t columns_;
  std::size_t rows_;
  std::vector<std::int32_t> site_row_;  ///< nearest in the column of each pixel, or kNoSite
  std::vector<std::int64_t> heights_;
  std::vector<std::int32_t> nearest_;
  RowEnvelope envelope_;
};

}  // namespace octavo
