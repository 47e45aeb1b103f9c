#include "octavo/mesh/triangle_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "octavo/mesh/cancellation.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_crossing.h"
#include "octavo/octree/o_code.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/parallel_sort.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// The o-code of a place in a cube of 2^21 steps around all points.
class PlaceCode {
 public:
  explicit PlaceCode(const SpaceBox& all) : lo_(all.lo) {
    float side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      side = std::max(side, all.hi[axis] - all.lo[axis]);
    }
    steps_ = side > 0 ? static_cast<float>((1 << 21) - 1) / side : 0;
  }
  std::uint64_t of(const SpaceBox& box) const {
    const auto step = [&](std::size_t axis) {
      const float middle = (box.lo[axis] + box.hi[axis]) / 2;
      return static_cast<std::int64_t>((middle - lo_[axis]) * steps_);
    };
    return interleave({step(0), step(1), step(2)});
  }

 private:
  MeshPoint lo_;
  float steps_ = 0;
};

double squared_distance_to(const SpaceBox& box, const Point3& place) {
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double below = static_cast<double>(box.lo[axis]) - place[axis];
    const double above = place[axis] - static_cast<double>(box.hi[axis]);
    const double outside = std::max({below, above, 0.0});
    squared += outside * outside;
  }
  return squared;
}

}  // namespace

SpaceBox box_of_triangle(const TriangleMesh& mesh, const MeshTriangle& triangle) {
  SpaceBox box;
  for (const std::uint32_t point : triangle) box.add(mesh.points[point]);
  return box;
}

TriangleTree::TriangleTree(const TriangleMesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
  SpaceBox all;
  for (const MeshPoint& point : mesh.points) all.add(point);
  const PlaceCode code(all);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> coded(order_.size());
  parallel_for(std::size_t{0}, coded.size(), [&](std::size_t i) {
    coded[i] = {code.of(box_of_triangle(mesh, mesh.triangles[i])), static_cast<std::uint32_t>(i)};
  });
  parallel_sort(coded);

  leaves_ = std::bit_ceil(static_cast<std::uint32_t>((order_.size() + kLeaf - 1) / kLeaf));
  boxes_.resize(std::size_t{2} * leaves_);
  own_boxes_.resize(order_.size());
  parallel_for(std::size_t{0}, std::size_t{leaves_}, [&](std::size_t leaf) {
    const std::size_t end = std::min((leaf + 1) * kLeaf, order_.size());
    for (std::size_t i = leaf * kLeaf; i < end; ++i) {
      order_[i] = coded[i].second;
      own_boxes_[i] = box_of_triangle(mesh, mesh.triangles[order_[i]]);
      boxes_[leaves_ + leaf].add(own_boxes_[i]);
    }
  });
  for (std::size_t node = leaves_ - 1; node > 0; --node) {
    boxes_[node] = boxes_[2 * node];
    boxes_[node].add(boxes_[2 * node + 1]);
  }
}

TriangleTree::Nearest TriangleTree::nearest(const Point3& place, double limit) const {
  Nearest found{kNone, limit};
  if (order_.empty()) return found;
  double best = limit * limit;
  struct Waiting {
    std::uint32_t node;
    double squared;
  };
  std::array<Waiting, 64> waiting;
  std::size_t count = 0;
  waiting[count++] = {1, squared_distance_to(boxes_[1], place)};
  while (count > 0) {
    const auto [node, squared] = waiting[--count];
    if (squared >= best) continue;
    if (node < leaves_) {
      // The nearer child is visited first.
      Waiting near = {2 * node, squared_distance_to(boxes_[2 * node], place)};
      Waiting far = {2 * node + 1, squared_distance_to(boxes_[2 * node + 1], place)};
      if (far.squared < near.squared) std::swap(near, far);
      if (far.squared < best) waiting[count++] = far;
      if (near.squared < best) waiting[count++] = near;
      continue;
    }
    const std::size_t end = std::min((node - leaves_ + 1) * kLeaf, order_.size());
    for (std::size_t i = (node - leaves_) * kLeaf; i < end; ++i) {
      if (squared_distance_to(own_boxes_[i], place) >= best) continue;
      const double own =
          squared_distance(place, places_of(mesh_, mesh_.triangles[order_[i]]));
      if (own >= best) continue;
      best = own;
      found.triangle = order_[i];
    }
  }
  if (found.triangle != kNone) found.distance = std::sqrt(best);
  return found;
}

std::vector<std::uint32_t> crossing_triangles(const TriangleTree& tree, const Progress& progress) {
  std::vector<std::uint32_t> all(tree.mesh().triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return crossing_triangles(tree, all, progress);
}

std::vector<std::uint32_t> crossing_triangles(const TriangleTree& tree,
                                              std::span<const std::uint32_t> triangles,
                                              const Progress& progress) {
  const TriangleMesh& mesh = tree.mesh();
  std::vector<std::uint8_t> is_asked(mesh.triangles.size());
  for (const std::uint32_t number : triangles) is_asked[number] = 1;
  PerThread<std::vector<std::uint32_t>> found;
  parallel_for(std::size_t{0}, triangles.size(), [&](std::size_t i) {
    stop_now_and_then(i, progress);
    const std::uint32_t number = triangles[i];
    const MeshTriangle& triangle = mesh.triangles[number];
    const SpaceBox box = box_of_triangle(mesh, triangle);
    const TrianglePlaces places = places_of(mesh, triangle);
    tree.visit(box, [&](std::uint32_t other) {
      // A pair of two that are asked for is looked at once.
      if (other == number || (other < number && is_asked[other] != 0)) return true;
      const MeshTriangle& second = mesh.triangles[other];
      if (!box_of_triangle(mesh, second).meets(box)) return true;
      if (do_cross(places, triangle, places_of(mesh, second), second)) {
        found.local().insert(found.local().end(), {number, other});
      }
      return true;
    });
  });
  std::vector<std::uint32_t> all;
  for (const std::vector<std::uint32_t>& some : found) {
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace octavo
