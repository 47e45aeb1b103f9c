#include "octavo/mesh/mesh_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/mesh/coincident_points.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

/// A side of a triangle at a point: to the next corner, and the one that comes back from the last.
struct CornerSides {
  std::uint32_t to;
  std::uint32_t from;
};

/// The corners of triangles at each point: a list through them, so that one look at the triangles
/// makes it. A corner is three times the number of its triangle, and its place there.
template <class Corner>
class PointCorners {
 public:
  explicit PointCorners(const TriangleMesh& mesh)
      : mesh_(mesh),
        last_(mesh.points.size(), kNone),
        before_(std::make_unique_for_overwrite<Corner[]>(3 * mesh.triangles.size())) {
    Corner corner = 0;
    for (const MeshTriangle& t : mesh.triangles) {
      for (const std::uint32_t point : t) {
        before_[corner] = std::exchange(last_[point], corner);
        ++corner;
      }
    }
  }

  /// Those of a point.
  void gather(std::size_t point, std::vector<CornerSides>& corners) const {
    corners.clear();
    for (Corner corner = last_[point]; corner != kNone; corner = before_[corner]) {
      const MeshTriangle& t = mesh_.triangles[corner / 3];
      const auto place = static_cast<std::size_t>(corner % 3);
      corners.push_back({t[(place + 1) % 3], t[(place + 2) % 3]});
    }
  }

 private:
  static constexpr Corner kNone = std::numeric_limits<Corner>::max();

  const TriangleMesh& mesh_;
  std::vector<Corner> last_;          // of each point
  std::unique_ptr<Corner[]> before_;  // of each corner: the one at the same point before it
};

/// Whether the triangles around a point make one fan: from each to the next by the side that they
/// share, once through all of them. So no two of them begin, or end, with the same side.
bool is_one_fan(std::span<const CornerSides> corners) {
  std::size_t reached = 0;
  std::uint32_t at = corners[0].to;
  do {
    const auto next = std::find_if(corners.begin(), corners.end(),
                                   [&](const CornerSides& c) { return c.to == at; });
    if (next == corners.end()) return false;
    at = next->from;
    ++reached;
  } while (at != corners[0].to && reached <= corners.size());
  return reached == corners.size();
}

/// Counts the faults at a point whose triangles make no single fan.
void add_faults(std::span<const CornerSides> corners, MeshCheck& check) {
  bool are_fans = true;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto has_end = [&](const CornerSides& c) { return c.from == corners[i].to; };
    const auto has_start = [&](const CornerSides& c) { return c.to == corners[i].to; };
    const auto ends = std::count_if(corners.begin(), corners.end(), has_end);
    const auto starts = std::count_if(corners.begin(), corners.end(), has_start);
    if (ends == 0) ++check.open_sides;
    // Counted at the first corner that has it.
    const bool is_first = std::find_if(corners.begin(), corners.end(), has_start) ==
                          corners.begin() + static_cast<std::ptrdiff_t>(i);
    if (is_first) check.repeated_sides += static_cast<std::uint64_t>(starts - 1);
    are_fans = are_fans && ends == 1 && starts == 1;
  }
  if (are_fans) ++check.pinched_points;
}

/// What the triangles around one point say.
void add_point(std::span<const CornerSides> corners, MeshCheck& check) {
  if (corners.empty()) return;
  ++check.euler_number;
  if (!is_one_fan(corners)) add_faults(corners, check);
}

MeshCheck sum_of(const MeshCheck& a, const MeshCheck& b) {
  MeshCheck sum = a;
  sum.open_sides += b.open_sides;
  sum.repeated_sides += b.repeated_sides;
  sum.pinched_points += b.pinched_points;
  sum.euler_number += b.euler_number;
  return sum;
}

/// What the triangles around all points say.
template <class Corner>
MeshCheck check_points(const TriangleMesh& mesh) {
  const PointCorners<Corner> corners(mesh);
  return parallel_reduce(
      std::size_t{0}, mesh.points.size(), 4096, MeshCheck(),
      [&](std::size_t begin, std::size_t end, MeshCheck part) {
        std::vector<CornerSides> around;
        for (std::size_t i = begin; i < end; ++i) {
          corners.gather(i, around);
          add_point(around, part);
        }
        return part;
      },
      sum_of);
}

}  // namespace

MeshCheck check_mesh(const TriangleMesh& mesh) {
  const bool is_short = mesh.triangles.size() < std::numeric_limits<std::uint32_t>::max() / 3;
  MeshCheck check =
      is_short ? check_points<std::uint32_t>(mesh) : check_points<std::uint64_t>(mesh);
  // Every triangle has three sides, half an edge each.
  check.euler_number -= static_cast<std::int64_t>(mesh.triangles.size() + 1) / 2;
  check.coincident_points = coincident_points(mesh.points);
  check.components = mesh_pieces(mesh).count;
  return check;
}

MeshMeasures measure_mesh(const TriangleMesh& mesh) {
  MeshMeasures measures;
  if (mesh.points.empty()) return measures;
  // From a point of the mesh, as volumes from a far origin cancel badly.
  const Point3 origin = place_of_point(mesh.points.front());
  for (const MeshTriangle& t : mesh.triangles) {
    const Point3 a = difference(place_of_point(mesh.points[t[0]]), origin);
    const Point3 b = difference(place_of_point(mesh.points[t[1]]), origin);
    const Point3 c = difference(place_of_point(mesh.points[t[2]]), origin);
    const Point3 normal = cross(difference(b, a), difference(c, a));
    measures.area_mm2 += std::sqrt(dot(normal, normal)) / 2;
    measures.volume_mm3 += dot(a, cross(b, c)) / 6;
  }
  return measures;
}

}  // namespace octavo
