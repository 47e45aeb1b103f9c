#include "octavo/mesh/mesh_parts.h"

#include <cmath>
#include <utility>

#include "octavo/core/vectors.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/parallel_sort.h"

namespace octavo {

namespace {

constexpr std::uint32_t kNoPart = 0xffffffff;

}  // namespace

PartTriangles cut_in_parts(const TriangleMesh& mesh, const Geometry& geometry, double side,
                           double shift) {
  std::vector<std::pair<MeshPartPlace, std::uint32_t>> placed(mesh.triangles.size());
  parallel_for(std::size_t{0}, placed.size(), [&](std::size_t i) {
    const TrianglePlaces places = places_of(mesh, mesh.triangles[i]);
    const Point3 middle =
        geometry.to_index(scaled(sum(sum(places[0], places[1]), places[2]), 1.0 / 3));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      placed[i].first[2 - axis] =
          static_cast<std::int32_t>(std::floor((middle[axis] + 1) / side + shift));
    }
    placed[i].second = static_cast<std::uint32_t>(i);
  });
  parallel_sort(placed);
  PartTriangles parts;
  parts.order.resize(placed.size());
  parts.is_seam.resize(mesh.points.size());
  std::vector<std::uint32_t> part_of(mesh.points.size(), kNoPart);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (i == 0 || placed[i].first != placed[i - 1].first) {
      if (i > 0) parts.ends.push_back(i);
      parts.places.push_back(placed[i].first);
    }
    parts.order[i] = placed[i].second;
    const auto part = static_cast<std::uint32_t>(parts.ends.size());
    for (const std::uint32_t point : mesh.triangles[placed[i].second]) {
      if (part_of[point] == kNoPart) part_of[point] = part;
      else if (part_of[point] != part) parts.is_seam[point] = 1;
    }
  }
  parts.ends.push_back(placed.size());
  return parts;
}

}  // namespace octavo
