// Places that three numbers of 16 bits can say.
#pragma once

#include <array>
#include <cstdint>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// origin + step * k along each axis, k in [0, 65535], mm in LPS.
struct PointGrid {
  static constexpr int kMost = 65535;

  Point3 origin_mm{};
  double step_mm = 0;  ///< above 0

  /// The grid that a mesh and `margin_mm` around it fill.
  static PointGrid around(const TriangleMesh& mesh, double margin_mm);

  /// Of the place nearest to a point.
  std::array<std::uint16_t, 3> numbers_of(const MeshPoint& point) const;
  MeshPoint place_of(const std::array<std::uint16_t, 3>& numbers) const;

  /// How far at most a point within the grid lies from the place nearest to it, as floats round.
  double largest_move_mm() const;

  /// Moves every point to the place nearest to it.
  void snap(TriangleMesh& mesh) const;
};

}  // namespace octavo
