// A tree of boxes around triangles, to find those near a place.
//
// Triangles are sorted by the o-code of their middles, eight to a leaf; the leaves are those of a
// complete binary tree, whose nodes stand in one array: children of node i are 2 i and 2 i + 1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// A closed box in space.
struct SpaceBox {
  MeshPoint lo{kFar, kFar, kFar};
  MeshPoint hi{-kFar, -kFar, -kFar};

  static constexpr float kFar = std::numeric_limits<float>::infinity();

  void add(const MeshPoint& point) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = point[axis] < lo[axis] ? point[axis] : lo[axis];
      hi[axis] = point[axis] > hi[axis] ? point[axis] : hi[axis];
    }
  }
  /// An empty box adds nothing.
  void add(const SpaceBox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = box.lo[axis] < lo[axis] ? box.lo[axis] : lo[axis];
      hi[axis] = box.hi[axis] > hi[axis] ? box.hi[axis] : hi[axis];
    }
  }
  bool meets(const SpaceBox& other) const {
    return lo[0] <= other.hi[0] && other.lo[0] <= hi[0] && lo[1] <= other.hi[1] &&
           other.lo[1] <= hi[1] && lo[2] <= other.hi[2] && other.lo[2] <= hi[2];
  }
};

SpaceBox box_of_triangle(const TriangleMesh& mesh, const MeshTriangle& triangle);

/// Immutable. The mesh must outlive this and stay as it is.
class TriangleTree {
 public:
  /// Uses the threads of the calling task arena. Memory 34 to 40 bytes per triangle, and 16 more
  /// while the tree is made.
  explicit TriangleTree(const TriangleMesh& mesh);

  const TriangleMesh& mesh() const { return mesh_; }

  static constexpr std::uint32_t kNone = 0xffffffff;

  /// The triangle nearest to a place among those at less than `limit`, and the distance; kNone and
  /// `limit` where there is none.
  struct Nearest {
    std::uint32_t triangle = kNone;
    double distance = 0;
  };
  Nearest nearest(const Point3& place, double limit) const;

  /// Calls visit(triangle number) for all triangles in leaves whose boxes meet `box`, until it
  /// gives false. Triangles besides those that meet it are visited, too.
  template <class Visit>
  void visit(const SpaceBox& box, Visit&& visit) const {
    if (order_.empty()) return;
    std::array<std::uint32_t, 64> waiting;
    std::size_t count = 0;
    waiting[count++] = 1;
    while (count > 0) {
      const std::uint32_t node = waiting[--count];
      if (!boxes_[node].meets(box)) continue;
      if (node < leaves_) {
        waiting[count++] = 2 * node + 1;
        waiting[count++] = 2 * node;
        continue;
      }
      const std::size_t first = std::size_t{node - leaves_} * kLeaf;
      const std::size_t end = first + kLeaf < order_.size() ? first + kLeaf : order_.size();
      for (std::size_t i = first; i < end; ++i) {
        if (!visit(order_[i])) return;
      }
    }
  }

 private:
  static constexpr std::size_t kLeaf = 8;

  const TriangleMesh& mesh_;
  std::uint32_t leaves_ = 1;
  std::vector<std::uint32_t> order_;  // triangle numbers, leaf by leaf
  std::vector<SpaceBox> boxes_;       // of nodes, the root at 1
  std::vector<SpaceBox> own_boxes_;   // of the triangles of order_
};

/// The triangles that cross or touch another one where they should not, ascending. Uses the threads
/// of the calling task arena. Exact.
/// progress  is asked whether to stop, and told nothing
/// Throws  Error{cancelled}
std::vector<std::uint32_t> crossing_triangles(const TriangleTree& tree, const Progress& progress);

/// Those of the pairs that have one of some triangles.
std::vector<std::uint32_t> crossing_triangles(const TriangleTree& tree,
                                              std::span<const std::uint32_t> triangles,
                                              const Progress& progress);

}  // namespace octavo
