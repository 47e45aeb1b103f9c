#include "octavo/mesh/nets/touching_points.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

namespace {

struct PointsAround {
  Point3 sum{};
  double count = 0;
};

}  // namespace

void move_apart(std::span<const std::uint32_t> points, TriangleMesh& mesh) {
  if (points.empty()) return;
  // Triangles around a point have each of the others twice.
  std::vector<PointsAround> around(points.size());
  for (const MeshTriangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto at = std::lower_bound(points.begin(), points.end(), t[k]);
      if (at == points.end() || *at != t[k]) continue;
      PointsAround& own = around[static_cast<std::size_t>(at - points.begin())];
      const Point3 place = place_of_point(mesh.points[t[k]]);
      for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3}) {
        own.sum = sum(own.sum, difference(place_of_point(mesh.points[t[other]]), place));
        own.count += 1;
      }
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    MeshPoint& point = mesh.points[points[i]];
    const Point3 place =
        sum(place_of_point(point), scaled(around[i].sum, kApartShare / around[i].count));
    for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(place[axis]);
  }
}

}  // namespace octavo
