// What counts as inside when a surface is taken from a volume, and where it cuts between voxels.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/volume.h"

namespace octavo {

/// Stored values from lowest to highest, both included. NaN and infinities are in none.
struct InsideRange {
  double lowest = 0;
  double highest = 0;
};

/// How near to a voxel the surface may cut, as a share of the way to the next.
inline constexpr double kNearestCrossing = 1.0 / 256;

struct SurfaceField {
  /// A voxel lies inside where its value is in one of them.
  std::vector<InsideRange> inside;
  /// Of grey values: between two voxels the surface cuts where this value would be. Without it, as
  /// of labels, in the middle.
  std::optional<double> isovalue;

  /// What is at or above a stored value, or with `is_falling` at or below it. Of integers the
  /// surface lies half a step before it, so that it encloses just those voxels.
  static SurfaceField of_grey(double value, bool is_falling, VoxelType type);
  /// Voxels of these labels, or with none all but 0.
  static SurfaceField of_labels(std::span<const std::int64_t> labels);
};

/// How many voxels lie inside among those whose values are lowest .. highest.
enum class InsideShare { none, some, all };

/// may_hold_others  the range is that of the finite voxels among them
InsideShare inside_share(const SurfaceField& field, double lowest, double highest,
                         bool may_hold_others);

/// Tells which voxels of a type T lie inside.
template <class T>
class InsideTest {
 public:
  explicit InsideTest(const SurfaceField& field);
  /// One bit for each of up to 64 voxels of a row: whether it lies inside.
  std::uint64_t bits(const T* row, int count) const;

 private:
  struct Range {
    T lowest;
    T highest;
  };
  std::vector<Range> ranges_;
};

/// Finds where the surface cuts between two voxels of a type T.
template <class T>
class CrossingFinder {
 public:
  explicit CrossingFinder(const SurfaceField& field)
      : is_middle_(!field.isovalue), isovalue_(field.isovalue.value_or(0)) {}

  /// As a share of the way from a to b: never nearer than 1/256 to either, so that points stay
  /// apart when they are rounded. In the middle beside NaN and infinities, where there is no place
  /// to prefer.
  double between(T a, T b) const {
    if (is_middle_) return 0.5;
    if constexpr (!std::numeric_limits<T>::is_integer) {
      if (!std::isfinite(a) || !std::isfinite(b)) return 0.5;
    }
    const auto from = static_cast<double>(a);
    const double share = (isovalue_ - from) / (static_cast<double>(b) - from);
    return std::clamp(share, kNearestCrossing, 1 - kNearestCrossing);
  }

 private:
  bool is_middle_;
  double isovalue_;
};

/// The same between a voxel inside and the outside of the volume, from the voxel on: half a voxel
/// off labels, next to grey values, which are taken to fall off at once.
double crossing_at_border(const SurfaceField& field);

}  // namespace octavo
