// Exact sums over the voxels of a region, from which its centroid and covariance follow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "octavo/core/box.h"

namespace octavo {

/// Counts, and sums of the coordinates of voxels and of their products. The order in which voxels
/// are added means nothing.
struct MomentSums {
  std::uint64_t count = 0;
  Box box;                           ///< empty without voxels
  std::array<__int128, 3> first{};   ///< x, y, z
  std::array<__int128, 6> second{};  ///< xx, yy, zz, xy, xz, yz

  /// The axes of each entry of `second`.
  static constexpr std::size_t kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

  /// Adds the voxels of a box, whose corners are not below 0.
  void add_box(const Box& more) {
    const Size3 size = more.size();
    count += static_cast<std::uint64_t>(size.voxel_count());
    box = united(box, more);
    std::array<__int128, 3> along;  // sum of the coordinate over one line
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const auto lines = static_cast<__int128>(size.voxel_count() / size[axis]);
      along[a] = sum_below(more.hi[axis]) - sum_below(more.lo[axis]);
      first[a] += along[a] * lines;
      second[a] += (squares_below(more.hi[axis]) - squares_below(more.lo[axis])) * lines;
    }
    second[3] += along[0] * along[1] * size.z;
    second[4] += along[0] * along[2] * size.y;
    second[5] += along[1] * along[2] * size.x;
  }

  void add(const MomentSums& more) {
    count += more.count;
    box = united(box, more.box);
    for (std::size_t i = 0; i < 3; ++i) first[i] += more.first[i];
    for (std::size_t i = 0; i < 6; ++i) second[i] += more.second[i];
  }

  /// Mean position. Requires count > 0.
  std::array<double, 3> centroid() const {
    return {static_cast<double>(mean(0)), static_cast<double>(mean(1)),
            static_cast<double>(mean(2))};
  }

  /// xx, yy, zz, xy, xz, yz about the centroid. Requires count > 0.
  std::array<double, 6> covariance() const {
    std::array<double, 6> result{};
    for (std::size_t i = 0; i < 6; ++i) {
      const long double product = static_cast<long double>(second[i]) / count;
      result[i] = static_cast<double>(product - mean(kPairs[i][0]) * mean(kPairs[i][1]));
    }
    return result;
  }

  /// Sum of i, and of i * i, for 0 <= i < n. Requires n >= 0.
  static __int128 sum_below(std::int64_t n) { return static_cast<__int128>(n) * (n - 1) / 2; }
  static __int128 squares_below(std::int64_t n) {
    return static_cast<__int128>(n) * (n - 1) * (2 * n - 1) / 6;
  }

 private:
  long double mean(std::size_t axis) const {
    return static_cast<long double>(first[axis]) / static_cast<long double>(count);
  }
};

}  // namespace octavo
