// Planes made of other planes, voxel by voxel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "octavo/core/voxel_type.h"

namespace octavo {

/// value = (sum of weight[i] * plane[i]) / divisor.
/// Whole weights over a whole divisor make halves exact, so that rounding them is well defined.
struct PlaneWeights {
  std::array<std::span<const std::byte>, 4> planes;  ///< of one size; weight 0: not read
  std::array<double, 4> weights{};                   ///< their sum is the divisor
  double divisor = 1;
};

/// How values are mixed.
struct Mixing {
  bool takes_nearest = false;           ///< labels: the voxel of the heaviest plane
  std::optional<std::int64_t> padding;  ///< a stored value that is no measurement
};

/// Fills `out` with mixed voxels of `type`; `out` may be one of the planes.
/// Integers are rounded to the nearest, halves up, and held within their type. Where all planes
/// agree the value stays as it is. Where padding, NaN or an infinity takes part, the voxel of the
/// heaviest plane is taken, of the last one where two weigh the same.
/// Thread-safe; no memory.
void mix_planes(VoxelType type, const PlaneWeights& mix, const Mixing& mixing,
                std::span<std::byte> out);

/// The nearest integer within its type, halves up; a float as it is, within its range.
template <class T>
T nearest_value(double value) {
  constexpr auto kLowest = static_cast<double>(std::numeric_limits<T>::lowest());
  constexpr auto kLargest = static_cast<double>(std::numeric_limits<T>::max());
  const double whole = std::is_floating_point_v<T> ? value : std::floor(value + 0.5);
  return static_cast<T>(std::clamp(whole, kLowest, kLargest));
}

}  // namespace octavo
