#include "octavo/mesh/mesh_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "octavo/mesh/point_distance.h"

namespace octavo {

namespace {

/// Of each point one that hangs together with it and has a lower number, in the end the lowest.
///
/// Where points are numbered in the order of their places, almost all come to the lowest one by the
/// lowest neighbor of each: then few sets are left to be joined.
class LowestMembers {
 public:
  explicit LowestMembers(std::size_t count) : lower_(count, MeshPieces::kNone) {}

  /// Begins with neighbors; points of no triangle stay without one.
  void begin(const TriangleMesh& mesh) {
    for (const MeshTriangle& t : mesh.triangles) {
      const std::uint32_t lowest = std::min({t[0], t[1], t[2]});
      for (const std::uint32_t point : t) lower_[point] = std::min(lower_[point], lowest);
    }
    shorten();
  }

  void join(std::uint32_t a, std::uint32_t b) {
    if (lower_[a] == lower_[b]) return;
    a = lowest_of(a);
    b = lowest_of(b);
    if (a < b) lower_[b] = a;
    else lower_[a] = b;
  }

  std::vector<std::uint32_t> take() {
    shorten();
    return std::move(lower_);
  }

 private:
  std::uint32_t lowest_of(std::uint32_t point) {
    while (lower_[point] != point) {
      lower_[point] = lower_[lower_[point]];
      point = lower_[point];
    }
    return point;
  }

  /// Lower points come first, so that each finds the lowest one in one step.
  void shorten() {
    for (std::uint32_t& lower : lower_) {
      if (lower != MeshPieces::kNone) lower = lower_[lower];
    }
  }

  std::vector<std::uint32_t> lower_;
};

}  // namespace

MeshPieces mesh_pieces(const TriangleMesh& mesh) {
  MeshPieces pieces;
  LowestMembers members(mesh.points.size());
  members.begin(mesh);
  for (const MeshTriangle& t : mesh.triangles) {
    members.join(t[0], t[1]);
    members.join(t[0], t[2]);
  }
  pieces.of_point = members.take();
  for (std::uint32_t i = 0; i < mesh.points.size(); ++i) {
    std::uint32_t& own = pieces.of_point[i];
    if (own == MeshPieces::kNone) continue;
    own = own == i ? static_cast<std::uint32_t>(pieces.count++) : pieces.of_point[own];
  }
  return pieces;
}

NearestTriangle nearest_triangle(const TriangleMesh& mesh, const Point3& place) {
  NearestTriangle nearest;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const double squared = squared_distance(place, places_of(mesh, mesh.triangles[i]));
    if (squared >= best) continue;
    best = squared;
    nearest.triangle = static_cast<std::uint32_t>(i);
  }
  nearest.distance_mm = std::sqrt(best);
  return nearest;
}

TriangleMesh piece_of_point(const TriangleMesh& mesh, std::uint32_t point) {
  const MeshPieces pieces = mesh_pieces(mesh);
  const std::uint32_t wanted = pieces.of_point[point];
  std::vector<std::uint32_t> numbers(mesh.points.size());
  TriangleMesh piece;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (pieces.of_point[i] != wanted) continue;
    numbers[i] = static_cast<std::uint32_t>(piece.points.size());
    piece.points.push_back(mesh.points[i]);
  }
  for (const MeshTriangle& t : mesh.triangles) {
    if (pieces.of_point[t[0]] != wanted) continue;
    piece.triangles.push_back({numbers[t[0]], numbers[t[1]], numbers[t[2]]});
  }
  return piece;
}

}  // namespace octavo
