// What every method of decimation begins and ends with: places near the surface, the deviation
// that is proven, pieces that stay as they are turned, and the mesh that is left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/vectors.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/point_distance.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

/// Whether a deviation is more than what rounding takes of it.
bool can_be_proven(double max_deviation_mm, const Geometry& geometry);

/// The full surface as it is, where nothing can be taken away: it has no triangles, or a deviation
/// as small cannot be proven. Throws as require_numbered.
std::optional<Decimated> undecimated(const TriangleMesh& full, const DecimationOptions& options,
                                     const Progress& progress);

/// Looks at a full surface that outlives it. Points of other meshes have its numbers; they may have
/// triangles at points that no triangle of the full surface has.
class DecimationFrame {
 public:
  /// Requires a surface with triangles.
  DecimationFrame(const TriangleMesh& full, const DecimationOptions& options);

  /// Places are computed near the first point of the surface.
  Point3 place(const MeshPoint& point) const {
    return difference(place_of_point(point), origin_);
  }
  MeshPoint point_at(const Point3& place) const {
    const Point3 world = sum(place, origin_);
    return {static_cast<float>(world[0]), static_cast<float>(world[1]),
            static_cast<float>(world[2])};
  }

  /// What is asked for less a margin for rounding, mm: this is proven.
  double deviation() const { return deviation_; }

  std::span<const std::uint32_t> locked() const { return locked_; }

  /// Pieces with one of these points are not looked at by turned_triangles, either: they are open.
  void hold(std::span<const std::uint32_t> points);

  /// The triangles of pieces that are turned inside out: a large deviation lets a piece pass
  /// through itself as a whole, without any triangle that crosses another. Pieces with locked
  /// points may be open and are not looked at.
  std::vector<std::uint32_t> turned_triangles(const TriangleMesh& mesh) const;

  /// The full surface, of which nothing less is proven.
  Decimated undecimated(int rounds, const TriangleTree& full_tree,
                        const Progress& progress) const;

  /// A mesh without the points that no triangle has and that are not locked.
  Decimated compacted(const TriangleMesh& mesh, int rounds, std::uint64_t crossing_count) const;

 private:
  /// Of points that no triangle of the full surface has: the last.
  std::size_t piece_of(std::uint32_t point) const {
    const std::uint32_t piece = pieces_.of_point[point];
    return piece == MeshPieces::kNone ? static_cast<std::size_t>(pieces_.count) : piece;
  }
  std::vector<double> piece_volumes(const TriangleMesh& mesh) const;

  const TriangleMesh& full_;
  std::span<const std::uint32_t> locked_;
  Point3 origin_;
  double deviation_;
  MeshPieces pieces_;
  std::vector<bool> is_held_;    // pieces with locked points
  std::vector<double> volumes_;  // of pieces, and of triangles of none
};

/// Of a voxel, mm.
double shortest_side(const Geometry& geometry);

}  // namespace octavo
