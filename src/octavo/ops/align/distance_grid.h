// Distances that are asked for between voxels and beside the volume, with the way they grow.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"

namespace octavo {

/// A distance in mm and its gradient in world space.
struct GridDistance {
  double mm = 0;
  Point3 slope{};
};

/// Samples of distances, every `step` voxels along each axis. Immutable; serves any number of
/// threads.
class DistanceGrid {
 public:
  /// mm    distances of the voxels of a volume of `size`, [z][y][x]
  /// step  1 or more
  /// Memory  4 bytes a sample
  DistanceGrid(const std::vector<float>& mm, const Size3& size, const Geometry& geometry,
               std::int64_t step);

  /// Interpolated between samples; beside the volume, that of the nearest place in it and how far
  /// that is.
  GridDistance at(const Point3& world) const;

  /// A place in samples along each axis, 0 at the first.
  Point3 to_samples(const Point3& world) const;
  /// What at() says of a place in samples, without the way it grows: a search along a line asks
  /// for many.
  double mm_at(const Point3& samples) const;
  /// Nothing above that, of the nearest sample alone.
  double mm_at_least(const Point3& samples) const;

  /// From one sample to the next along the axis on which they are closest.
  double sample_mm() const;

 private:
  Size3 size_;
  double step_;
  Geometry geometry_;
  std::array<double, 9> to_index_{};  ///< rows: samples per mm
  Point3 last_{};                     ///< samples along each axis, less 1
  Point3 apart_mm_{};                 ///< from one sample to the next along each axis
  double half_diagonal_mm_ = 0;       ///< from any place to the nearest sample, at most
  std::vector<float> samples_;
};

}  // namespace octavo
