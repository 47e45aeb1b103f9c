#include "octavo/mesh/measured_deviation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr double kStep = 1.05;

/// Measures one direction: how far a mesh lies from the surface of a tree.
class OneWay {
 public:
  OneWay(const TriangleMesh& mesh, const TriangleTree& tree, double known,
         const Progress& progress)
      : mesh_(mesh), tree_(tree), known_(known), progress_(progress), near_(mesh.points.size()) {}

  /// At least `distance`, from which on it is proven.
  double proven_from(double distance) {
    distance = std::max(distance, kStep * farthest_point());
    std::vector<std::uint8_t> is_proven(mesh_.triangles.size());
    parallel_for(std::size_t{0}, is_proven.size(), [&](std::size_t i) {
      is_proven[i] = distance_to_one(mesh_.triangles[i]) <= distance ? 1 : 0;
    });
    while (distance < known_) {
      const std::vector<std::uint32_t> left =
          unproven_triangles(mesh_, tree_, distance, progress_, {}, is_proven);
      if (left.empty()) return distance;
      std::fill(is_proven.begin(), is_proven.end(), std::uint8_t{1});
      for (const std::uint32_t triangle : left) is_proven[triangle] = 0;
      distance *= kStep;
    }
    return known_;
  }

 private:
  double farthest_point() {
    std::vector<std::uint8_t> is_used(mesh_.points.size());
    for (const MeshTriangle& t : mesh_.triangles) {
      for (const std::uint32_t point : t) is_used[point] = 1;
    }
    parallel_for(std::size_t{0}, near_.size(), [&](std::size_t i) {
      stop_now_and_then(i, progress_);
      if (is_used[i] != 0) near_[i] = tree_.nearest(place_of_point(mesh_.points[i]), 2 * known_);
    });
    double farthest = 0;
    for (const TriangleTree::Nearest& near : near_) farthest = std::max(farthest, near.distance);
    return farthest;
  }

  /// How far a triangle lies at most from the nearest of those that its corners have.
  double distance_to_one(const MeshTriangle& triangle) const {
    const TrianglePlaces places = places_of(mesh_, triangle);
    double nearest = 2 * known_;
    for (const std::uint32_t corner : triangle) {
      if (near_[corner].triangle == TriangleTree::kNone) return nearest;
      const TriangleMesh& other = tree_.mesh();
      const TrianglePlaces t = places_of(other, other.triangles[near_[corner].triangle]);
      double farthest = 0;
      for (const Point3& place : places) farthest = std::max(farthest, squared_distance(place, t));
      nearest = std::min(nearest, std::sqrt(farthest));
    }
    return nearest;
  }

  const TriangleMesh& mesh_;
  const TriangleTree& tree_;
  double known_;
  const Progress& progress_;
  std::vector<TriangleTree::Nearest> near_;  // of points
};

}  // namespace

double measured_deviation(const TriangleMesh& a, const TriangleMesh& b, double known,
                          double margin, const Progress& progress) {
  if (!(known > margin)) return known;
  const TriangleTree a_tree(a);
  const TriangleTree b_tree(b);
  // Growing by a factor, the distance cannot begin at 0, where surfaces are the same.
  const double one = OneWay(a, b_tree, known - margin, progress).proven_from(margin);
  return OneWay(b, a_tree, known - margin, progress).proven_from(one) + margin;
}

}  // namespace octavo
