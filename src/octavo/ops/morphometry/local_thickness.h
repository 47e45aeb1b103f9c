// The local thickness of a class of voxels: the diameter of the largest ball that fits into the
// class and covers the voxel's center.
//
// Balls are painted the largest first, so that every voxel is written once; voxels that are not
// painted yet are bits of tiles of 8 x 8, and what is painted is passed over by whole tiles.
//
// Source  T. Hildebrand, P. Rüegsegger, A new method for the model-independent assessment of
//         thickness in three-dimensional images, Journal of Microscopy 185 (1997)
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/ops/morphometry/fitting_balls.h"

namespace octavo {

/// What voxels measure, each counted once.
struct ThicknessSummary {
  std::uint64_t voxels = 0;
  double mean_mm = 0;
  double deviation_mm = 0;
  double minimum_mm = 0;
  double maximum_mm = 0;
  double bin_mm = 0;                  ///< width of the bins, the first of which begins at 0
  std::vector<std::uint64_t> bins;    ///< voxels

  /// The thickness that a share of the voxels does not reach, as if those of a bin were spread
  /// evenly in it; none outside of the smallest and the largest. 0 without voxels.
  double quantile_mm(double share) const;
};

class LocalThickness {
 public:
  /// asked, balls  must outlive this; the balls are those of fitting_balls
  LocalThickness(const ThicknessClass& asked, const Point3& spacing_mm,
                 const std::vector<FittingBall>& balls);

  /// Writes the thickness of the voxels of planes [begin, end), mm; 0 where they are not of the
  /// class or not in the region. Uses the threads of the calling task arena.
  /// Memory  5 bytes for each voxel of the planes, 4 for each ball
  void read(std::int64_t begin, std::int64_t end, float* mm) const;

  /// Adds what was read of planes to a summary; `finish` makes means of its sums.
  void add(const float* mm, std::int64_t count, ThicknessSummary& summary) const;
  static void finish(ThicknessSummary& summary);

 private:
  class Plane;

  const ThicknessClass& asked_;
  Point3 spacing_;
  const std::vector<FittingBall>& balls_;
};

}  // namespace octavo
