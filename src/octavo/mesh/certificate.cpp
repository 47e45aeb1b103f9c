#include "octavo/mesh/certificate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/cover_proof.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// A corner of a part of a triangle, and a triangle of the other surface that is near to it.
struct NearCorner {
  Point3 place;
  TriangleTree::Nearest nearest;
};

using NearCorners = std::array<NearCorner, 3>;

bool is_found(const NearCorner& corner) { return corner.nearest.triangle != TriangleTree::kNone; }

NearCorners unknown(const TrianglePlaces& places) {
  return {{{places[0], {}}, {places[1], {}}, {places[2], {}}}};
}

Point3 middle(const NearCorner& a, const NearCorner& b) {
  return scaled(sum(a.place, b.place), 0.5);
}

double squared_side(const NearCorner& a, const NearCorner& b) {
  const Point3 side = difference(a.place, b.place);
  return dot(side, side);
}

/// Proves triangles by what `Finder` finds near places:
/// bool find(place, corners around it, depth, NearCorner& found).
template <class Finder>
class Certificate {
 public:
  Certificate(const TriangleMesh& other, double distance, const Finder& finder)
      : other_(other), distance_(distance), finder_(finder) {}

  bool proves(const NearCorners& corners, int depth) const {
    if (is_near_one(corners)) return true;
    // No point of a triangle is farther from the nearest corner than its longest side / sqrt(3).
    std::size_t at = 0;  // where the longest side begins
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double squared = squared_side(corners[k], corners[(k + 1) % 3]);
      if (squared <= longest) continue;
      longest = squared;
      at = k;
    }
    const double farthest = std::max({corners[0].nearest.distance, corners[1].nearest.distance,
                                      corners[2].nearest.distance});
    if (farthest + std::sqrt(longest) * 0.57736 <= distance_) return true;
    if (depth == 0) return false;
    const NearCorner& a = corners[at];
    const NearCorner& b = corners[(at + 1) % 3];
    const NearCorner& c = corners[(at + 2) % 3];
    NearCorner halfway;
    if (!finder_.find(middle(a, b), corners, depth, halfway)) return false;
    // The half that is less likely to be proven comes first.
    if (a.nearest.distance > b.nearest.distance) {
      return proves({a, halfway, c}, depth - 1) && proves({halfway, b, c}, depth - 1);
    }
    return proves({halfway, b, c}, depth - 1) && proves({a, halfway, c}, depth - 1);
  }

 private:
  /// Whether all corners lie within the distance of the triangle that one of them has.
  bool is_near_one(const NearCorners& corners) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t number = corners[k].nearest.triangle;
      if (k > 0 && number == corners[0].nearest.triangle) continue;
      if (k > 1 && number == corners[1].nearest.triangle) continue;
      const TrianglePlaces places = places_of(other_, other_.triangles[number]);
      bool is_near = true;
      for (std::size_t i = 0; i < 3 && is_near; ++i) {
        is_near = corners[i].nearest.triangle == number || is_near_to(corners[i].place, places);
      }
      if (is_near) return true;
    }
    return false;
  }

  bool is_near_to(const Point3& place, const TrianglePlaces& t) const {
    // From a corner farther than distance and longest side together, by 2 (x^2 + y^2) >= (x + y)^2.
    const Point3 from = difference(place, t[0]);
    const Point3 ab = difference(t[1], t[0]);
    const Point3 ac = difference(t[2], t[0]);
    const double squared = distance_ * distance_;
    if (dot(from, from) > 2 * (squared + std::max(dot(ab, ab), dot(ac, ac)))) return false;
    return squared_distance(place, t) <= squared;
  }

  const TriangleMesh& other_;
  double distance_;
  const Finder& finder_;
};

constexpr int kDepth = 14;

/// Searches the tree, near the corners of small parts only where these do not do. Remembers what it
/// found.
class TreeFinder {
 public:
  TreeFinder(const TriangleTree& tree, double distance) : tree_(tree), distance_(distance) {}

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
    used_.push_back(found.nearest.triangle);
    return is_found(found);
  }

  /// Whether the triangle with these corners is proven; those that have no triangle near enough
  /// are given one.
  bool proves(NearCorners corners) const {
    used_.clear();
    for (NearCorner& corner : corners) {
      if (!is_found(corner) || corner.nearest.distance > kNearEnough * distance_) {
        corner.nearest = tree_.nearest(corner.place, distance_);
      }
      if (!is_found(corner)) return false;
      used_.push_back(corner.nearest.triangle);
    }
    return Certificate(tree_.mesh(), distance_, *this).proves(corners, kDepth);
  }

  /// The triangles that the last one was proven by, ascending.
  std::span<const std::uint32_t> used() const {
    std::sort(used_.begin(), used_.end());
    used_.erase(std::unique(used_.begin(), used_.end()), used_.end());
    return used_;
  }

 private:
  static constexpr int kSearchingDepth = 6;   // from which on the nearest is always sought
  static constexpr double kNearEnough = 0.6;  // of the distance: no nearer triangle is sought

  double distance_to(const Point3& place, std::uint32_t triangle) const {
    const TriangleMesh& mesh = tree_.mesh();
    return std::sqrt(squared_distance(place, places_of(mesh, mesh.triangles[triangle])));
  }

  const TriangleTree& tree_;
  double distance_;
  mutable std::vector<std::uint32_t> used_;
};

/// The nearest of the triangles of corners at less than `limit`, which is the distance where there
/// is none.
NearCorner nearest_of_corners(const TriangleMesh& mesh, const Point3& place,
                              const NearCorners& corners, double limit) {
  NearCorner found{place, {}};
  double best = limit * limit;
  for (const NearCorner& corner : corners) {
    const std::uint32_t number = corner.nearest.triangle;
    if (number == found.nearest.triangle) continue;
    const double own = squared_distance(place, places_of(mesh, mesh.triangles[number]));
    if (own >= best) continue;
    best = own;
    found.nearest.triangle = number;
  }
  found.nearest.distance = std::sqrt(best);
  return found;
}

/// Knows nothing but the triangles of the corners.
class CornerFinder {
 public:
  CornerFinder(const TriangleMesh& other, double distance) : other_(other), distance_(distance) {}

  static constexpr int kDepth = 4;

  bool find(const Point3& place, const NearCorners& corners, int /*depth*/,
            NearCorner& found) const {
    found = nearest_of_corners(other_, place, corners, distance_);
    return is_found(found);
  }

 private:
  const TriangleMesh& other_;
  double distance_;
};

/// Finds triangles around the nearest of some points; searches the tree where these are too far.
class PointFinder {
 public:
  PointFinder(const TriangleTree& tree, const PointTriangles& fans, double distance)
      : tree_(tree), other_(tree.mesh()), fans_(fans), distance_(distance) {}

  static constexpr int kDepth = 10;

  /// The attached point nearest to a place; kNone where there is none.
  std::uint32_t nearest_point(const Point3& place) const {
    return points_.empty() ? TriangleTree::kNone : points_[nearest_number(place)];
  }

  /// Takes the points that are attached to a triangle of a mesh and to those around it.
  void gather(const TriangleMesh& mesh, const MeshTriangle& triangle, const KnownNearby& known) {
    points_.clear();
    places_.clear();
    is_any_far_ = false;
    for (std::size_t k = 0; k < 3; ++k) {
      for (const std::uint32_t beside : known.mesh_fans.of(triangle[k])) {
        const MeshTriangle& t = mesh.triangles[beside];
        const auto end = triangle.begin() + static_cast<std::ptrdiff_t>(k);
        const bool is_known = std::find_first_of(t.begin(), t.end(), triangle.begin(), end) !=
                              t.end();
        if (!is_known) add(known.attached, beside);
      }
    }
  }

  bool find(const Point3& place, const NearCorners& corners, int /*depth*/,
            NearCorner& found) const {
    found = nearest_of_corners(other_, place, corners, kNearEnough * distance_);
    if (!is_found(found)) found.nearest = nearest(place);
    return is_found(found);
  }

  /// Whether a place was met near which there is no triangle.
  bool is_any_far() const { return is_any_far_; }

  TriangleTree::Nearest nearest(const Point3& place) const {
    if (places_.empty()) return searched(place);
    TriangleTree::Nearest found;
    double best = distance_ * distance_;
    for (const std::uint32_t number : fans_.of(points_[nearest_number(place)])) {
      const double own = squared_distance(place, places_of(other_, other_.triangles[number]));
      if (own >= best) continue;
      best = own;
      found.triangle = number;
    }
    if (found.triangle == TriangleTree::kNone) return searched(place);
    found.distance = std::sqrt(best);
    return found;
  }

 private:
  /// The place in points_ of the one nearest to a place. Requires one.
  std::size_t nearest_number(const Point3& place) const {
    const MeshPoint p = {static_cast<float>(place[0]), static_cast<float>(place[1]),
                         static_cast<float>(place[2])};
    float lowest = std::numeric_limits<float>::infinity();
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const float x = places_[i][0] - p[0];
      const float y = places_[i][1] - p[1];
      const float z = places_[i][2] - p[2];
      const float squared = x * x + y * y + z * z;
      if (squared >= lowest) continue;
      lowest = squared;
      nearest = i;
    }
    return nearest;
  }

  TriangleTree::Nearest searched(const Point3& place) const {
    const TriangleTree::Nearest found = tree_.nearest(place, distance_);
    if (found.triangle == TriangleTree::kNone) is_any_far_ = true;
    return found;
  }

  void add(const AttachedPoints& attached, std::uint32_t triangle) {
    for (std::uint32_t point = attached.first[triangle]; point != TriangleTree::kNone;
         point = attached.next[point]) {
      points_.push_back(point);
      places_.push_back(other_.points[point]);
    }
  }

  static constexpr double kNearEnough = 0.5;  // of the distance: no nearer triangle is sought

  const TriangleTree& tree_;
  const TriangleMesh& other_;
  const PointTriangles& fans_;
  double distance_;
  std::vector<std::uint32_t> points_;
  std::vector<MeshPoint> places_;
  mutable bool is_any_far_ = false;
};

/// Proves triangles by what is known of them: by what covers them, else near the points that are
/// attached around them, else by the tree.
class NearbyProof {
 public:
  NearbyProof(const TriangleMesh& mesh, const TriangleTree& tree, double distance,
              const KnownNearby& known)
      : mesh_(mesh),
        known_(known),
        points_(tree, known.other_fans, distance),
        cover_(tree.mesh(), known.other_fans, distance),
        by_points_(tree.mesh(), distance, points_),
        by_tree_(tree, distance) {}

  bool proves(std::uint32_t triangle) {
    points_.gather(mesh_, mesh_.triangles[triangle], known_);
    const TrianglePlaces places = places_of(mesh_, mesh_.triangles[triangle]);
    const Point3 middle = scaled(sum(sum(places[0], places[1]), places[2]), 1.0 / 3);
    const std::uint32_t near = points_.nearest_point(middle);
    return (near != TriangleTree::kNone && cover_.proves(places, near)) ||
           proves_near_points(places);
  }

 private:
  bool proves_near_points(const TrianglePlaces& places) {
    NearCorners corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = {places[k], points_.nearest(places[k])};
    if (std::all_of(corners.begin(), corners.end(), is_found) &&
        by_points_.proves(corners, PointFinder::kDepth)) {
      return true;
    }
    return !points_.is_any_far() && by_tree_.proves(unknown(places));
  }

  const TriangleMesh& mesh_;
  const KnownNearby& known_;
  PointFinder points_;
  CoverProof cover_;
  Certificate<PointFinder> by_points_;
  TreeFinder by_tree_;
};

using FoundTriangles = PerThread<std::vector<std::uint32_t>>;

std::vector<std::uint32_t> joined(const FoundTriangles& found) {
  std::vector<std::uint32_t> all;
  for (const std::vector<std::uint32_t>& some : found) {
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

void add_proof(SearchedProofs& proofs, std::uint32_t triangle, std::span<const std::uint32_t> by) {
  proofs.proven.push_back(triangle);
  proofs.by.insert(proofs.by.end(), by.begin(), by.end());
  proofs.ends.push_back(proofs.by.size());
}

/// Of points of some triangles of a mesh the triangle of the other surface that their hints name,
/// where that is near enough.
std::vector<TriangleTree::Nearest> hinted(const TriangleMesh& mesh,
                                          std::span<const std::uint8_t> is_left_out,
                                          const TriangleMesh& other,
                                          std::span<const std::uint32_t> hints, double distance) {
  std::vector<std::uint8_t> is_asked(mesh.points.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (is_left_out[i] != 0) continue;
    for (const std::uint32_t point : mesh.triangles[i]) is_asked[point] = 1;
  }
  std::vector<TriangleTree::Nearest> near(hints.size());
  parallel_for(std::size_t{0}, hints.size(), [&](std::size_t i) {
    if (is_asked[i] == 0 || hints[i] == TriangleTree::kNone) return;
    const double own = std::sqrt(squared_distance(
        place_of_point(mesh.points[i]), places_of(other, other.triangles[hints[i]])));
    if (own <= distance) near[i] = {hints[i], own};
  });
  return near;
}

}  // namespace

std::vector<std::uint32_t> unproven_triangles(const TriangleMesh& mesh, const TriangleTree& tree,
                                              double distance, const Progress& progress,
                                              std::span<const std::uint32_t> hints,
                                              std::span<std::uint8_t> is_known,
                                              SearchedProofs* searched) {
  std::vector<std::uint8_t> none;
  if (is_known.empty()) {
    none.resize(mesh.triangles.size());
    is_known = none;
  }
  std::vector<TriangleTree::Nearest> near;
  if (!hints.empty()) near = hinted(mesh, is_known, tree.mesh(), hints, distance);
  const CornerFinder known(tree.mesh(), distance);
  const Certificate by_hints(tree.mesh(), distance, known);
  PerThread<TreeFinder> finders([&] { return TreeFinder(tree, distance); });
  PerThread<SearchedProofs> proofs;
  FoundTriangles found;
  parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(mesh.triangles.size()),
                    [&](std::uint32_t number) {
    stop_now_and_then(number, progress);
    if (is_known[number] != 0) return;
    NearCorners corners = unknown(places_of(mesh, mesh.triangles[number]));
    if (!near.empty()) {
      for (std::size_t k = 0; k < 3; ++k) corners[k].nearest = near[mesh.triangles[number][k]];
      if (std::all_of(corners.begin(), corners.end(), is_found) &&
          by_hints.proves(corners, CornerFinder::kDepth)) {
        is_known[number] = 1;
        return;
      }
    }
    const TreeFinder& searching = finders.local();
    if (!searching.proves(corners)) found.local().push_back(number);
    else if (searched != nullptr) add_proof(proofs.local(), number, searching.used());
  });
  for (const SearchedProofs& some : proofs) {
    for (std::size_t i = 0; i < some.proven.size(); ++i) {
      add_proof(*searched, some.proven[i], some.of(i));
    }
  }
  return joined(found);
}

std::vector<std::uint32_t> unproven_triangles(const TriangleMesh& mesh,
                                              std::span<const std::uint32_t> triangles,
                                              const TriangleTree& tree, double distance,
                                              const KnownNearby& known,
                                              const Progress& progress) {
  constexpr std::size_t kChunk = 64;
  FoundTriangles found;
  parallel_for(std::size_t{0}, (triangles.size() + kChunk - 1) / kChunk,
                    [&](std::size_t chunk) {
    NearbyProof proof(mesh, tree, distance, known);
    const std::size_t end = std::min((chunk + 1) * kChunk, triangles.size());
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
      stop_if_cancelled(progress);
      if (!proof.proves(triangles[i])) found.local().push_back(triangles[i]);
    }
  });
  return joined(found);
}

}  // namespace octavo
