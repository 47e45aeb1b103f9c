// What groups of triangles enclose.
#pragma once

#include <cstddef>
#include <vector>

#include "octavo/core/triangle_mesh.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

/// For each of `count` groups the volume between its triangles and the first point of the mesh,
/// mm3: of a closed surface what it encloses, negative where it is turned inside out. Volumes from
/// a far origin cancel badly.
/// group_of  of the number of a triangle
template <class GroupOf>
std::vector<double> volumes_of_groups(const TriangleMesh& mesh, std::size_t count,
                                      GroupOf&& group_of) {
  std::vector<double> volumes(count);
  if (mesh.points.empty()) return volumes;
  const Point3 origin = place_of_point(mesh.points.front());
  const auto place = [&](std::uint32_t point) {
    return difference(place_of_point(mesh.points[point]), origin);
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const MeshTriangle& t = mesh.triangles[i];
    volumes[group_of(i)] += dot(place(t[0]), cross(place(t[1]), place(t[2]))) / 6;
  }
  return volumes;
}

}  // namespace octavo
