// The points of one part of a mesh, for formats whose objects have points of their own.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/triangle_mesh.h"

namespace octavo {

/// Gives the points of some triangles numbers in the order in which they come first.
class UsedPoints {
 public:
  explicit UsedPoints(const TriangleMesh& mesh)
      : mesh_(mesh), numbers_(mesh.points.size(), kNone) {}

  /// Takes the triangles [begin, end) in place of those before.
  void take(std::size_t begin, std::size_t end) {
    for (const std::uint32_t point : points_) numbers_[point] = kNone;
    points_.clear();
    for (std::size_t i = begin; i < end; ++i) {
      for (const std::uint32_t point : mesh_.triangles[i]) {
        if (numbers_[point] != kNone) continue;
        numbers_[point] = static_cast<std::uint32_t>(points_.size());
        points_.push_back(point);
      }
    }
  }

  /// Numbers of points of the mesh.
  const std::vector<std::uint32_t>& points() const { return points_; }

  /// A taken triangle in the new numbers.
  MeshTriangle triangle(std::size_t i) const {
    const MeshTriangle& t = mesh_.triangles[i];
    return {numbers_[t[0]], numbers_[t[1]], numbers_[t[2]]};
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> numbers_;  // of points of the mesh, kNone where not taken
  std::vector<std::uint32_t> points_;
};

}  // namespace octavo
