#include "octavo/mesh/certificate.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "octavo/core/error.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

namespace {

/// A corner of a part of a triangle, and the triangle of the other surface that is nearest to it.
struct NearCorner {
  Point3 place;
  TriangleTree::Nearest nearest;
};

using NearCorners = std::array<NearCorner, 3>;

class Certificate {
 public:
  Certificate(const TriangleTree& tree, double distance) : tree_(tree), distance_(distance) {}

  /// Whether all corners lie within the distance of one triangle.
  bool is_near(const TrianglePlaces& corners, std::uint32_t triangle) const {
    const TriangleMesh& mesh = tree_.mesh();
    const TrianglePlaces places = places_of(mesh, mesh.triangles[triangle]);
    return std::all_of(corners.begin(), corners.end(), [&](const Point3& corner) {
      return squared_distance(corner, places) <= distance_ * distance_;
    });
  }

  /// The triangle that `hint` names where it is near enough, else the nearest one.
  NearCorner corner_at(const Point3& place, std::uint32_t hint) const {
    if (hint != TriangleTree::kNone) {
      const double own = distance_to(place, hint);
      if (own <= kNearEnough * distance_) return {place, {hint, own}};
    }
    return {place, tree_.nearest(place, distance_)};
  }

  bool proves(const NearCorners& corners) const {
    return std::all_of(corners.begin(), corners.end(), is_found) && proves(corners, kDepth);
  }

 private:
  static constexpr int kDepth = 6;
  static constexpr int kSearchingDepth = 2;   // from which on the nearest is always sought
  static constexpr double kNearEnough = 0.6;  // of the distance: no nearer triangle is sought

  static bool is_found(const NearCorner& corner) {
    return corner.nearest.triangle != TriangleTree::kNone;
  }

  double distance_to(const Point3& place, std::uint32_t triangle) const {
    const TriangleMesh& mesh = tree_.mesh();
    return std::sqrt(squared_distance(place, places_of(mesh, mesh.triangles[triangle])));
  }

  /// The corner between two others of a part.
  bool find(const Point3& place, const NearCorners& corners, int depth, NearCorner& found) const {
    found = {place, {TriangleTree::kNone, kNearEnough * distance_}};
    if (depth > kSearchingDepth) {
      for (const NearCorner& corner : corners) {
        const double own = distance_to(place, corner.nearest.triangle);
        if (own < found.nearest.distance) found.nearest = {corner.nearest.triangle, own};
      }
      if (is_found(found)) return true;
    }
    found.nearest = tree_.nearest(place, distance_);
    return is_found(found);
  }

  bool proves(const NearCorners& corners, int depth) const {
    const auto& [a, b, c] = corners;
    const bool have_one = a.nearest.triangle == b.nearest.triangle &&
                          b.nearest.triangle == c.nearest.triangle;
    if (have_one) return true;
    for (const NearCorner& corner : corners) {
      if (is_near({a.place, b.place, c.place}, corner.nearest.triangle)) return true;
    }
    // No point of a triangle is farther from the nearest corner than its longest side / sqrt(3).
    const double longest = std::sqrt(std::max({squared_side(a, b), squared_side(b, c),
                                               squared_side(c, a)}));
    const double farthest = std::max(
        {a.nearest.distance, b.nearest.distance, c.nearest.distance});
    if (farthest + longest * 0.57736 <= distance_) return true;
    if (depth == 0) return false;
    NearCorner ab;
    NearCorner bc;
    NearCorner ca;
    if (!find(middle(a, b), corners, depth, ab) || !find(middle(b, c), corners, depth, bc) ||
        !find(middle(c, a), corners, depth, ca)) {
      return false;
    }
    return proves({a, ab, ca}, depth - 1) && proves({ab, b, bc}, depth - 1) &&
           proves({ca, bc, c}, depth - 1) && proves({ab, bc, ca}, depth - 1);
  }

  static Point3 middle(const NearCorner& a, const NearCorner& b) {
    return scaled(sum(a.place, b.place), 0.5);
  }
  static double squared_side(const NearCorner& a, const NearCorner& b) {
    const Point3 side = difference(a.place, b.place);
    return dot(side, side);
  }

  const TriangleTree& tree_;
  double distance_;
};

}  // namespace

std::vector<std::uint32_t> unproven_triangles(const TriangleMesh& mesh, const TriangleTree& tree,
                                              double distance, const Progress& progress,
                                              std::span<const std::uint32_t> hints) {
  const Certificate certificate(tree, distance);
  std::vector<std::uint8_t> is_used(mesh.points.size());
  for (const MeshTriangle& t : mesh.triangles) {
    for (const std::uint32_t point : t) is_used[point] = 1;
  }
  std::vector<NearCorner> corners(mesh.points.size());
  tbb::parallel_for(std::size_t{0}, corners.size(), [&](std::size_t i) {
    stop_now_and_then(i, progress);
    if (is_used[i] == 0) return;
    corners[i] = certificate.corner_at(place_of_point(mesh.points[i]),
                                       hints.empty() ? TriangleTree::kNone : hints[i]);
  });
  tbb::enumerable_thread_specific<std::vector<std::uint32_t>> found;
  tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(mesh.triangles.size()),
                    [&](std::uint32_t number) {
    stop_now_and_then(number, progress);
    const MeshTriangle& t = mesh.triangles[number];
    if (certificate.proves({corners[t[0]], corners[t[1]], corners[t[2]]})) return;
    found.local().push_back(number);
  });
  std::vector<std::uint32_t> all;
  for (const std::vector<std::uint32_t>& some : found) {
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace octavo
