// Points of the surface of a label that stand at one place, since the label touches itself there.
//
// A program that joins points by their places, as it must those of an STL file, would make one
// point of them, and an edge of four triangles. So they are moved apart, each a little way towards
// the points around it. A neighbor that lies around the same voxels has the same triangles there
// and moves its points alike; where both touch themselves along an edge the two differ by that way.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// How far a point is moved: as a share of the way to the mean of the points around it, which lie
/// within about a voxel.
inline constexpr double kApartShare = 1.0 / 128;

/// points  of the mesh, ascending
void move_apart(std::span<const std::uint32_t> points, TriangleMesh& mesh);

}  // namespace octavo
