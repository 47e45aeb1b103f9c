// Whether triangles make a surface that printers and solvers can take, proven by counting.
#pragma once

#include <cstdint>

#include "octavo/core/triangle_mesh.h"

namespace octavo {

struct MeshCheck {
  /// Sides of triangles beside which none runs the other way: the surface is not closed there, or
  /// neighbors are turned against each other.
  std::uint64_t open_sides = 0;
  /// Sides that a second triangle has in the same direction: more than two meet at an edge.
  std::uint64_t repeated_sides = 0;
  /// Points around which triangles make more than one fan: parts of the surface touch there.
  std::uint64_t pinched_points = 0;
  /// Points at the place of another one: whoever joins points by their places changes the surface.
  std::uint64_t coincident_points = 0;
  std::uint64_t components = 0;  ///< pieces that are connected by edges and points
  /// Points - edges + triangles, of a mesh that is closed and manifold.
  std::int64_t euler_number = 0;

  bool is_closed() const { return open_sides == 0; }
  bool is_manifold() const {
    return repeated_sides == 0 && pinched_points == 0 && coincident_points == 0;
  }
};

/// Uses the threads of the calling task arena. Points that no triangle has count for nothing.
/// Memory  about 70 bytes per point of a closed surface
MeshCheck check_mesh(const TriangleMesh& mesh);

struct MeshMeasures {
  double area_mm2 = 0;
  double volume_mm3 = 0;  ///< enclosed; negative where the surface is turned inside out
};

MeshMeasures measure_mesh(const TriangleMesh& mesh);

}  // namespace octavo
