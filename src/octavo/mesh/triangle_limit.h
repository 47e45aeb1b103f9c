// A surface with no more triangles than asked, and how far it lies from the full one, proven.
#pragma once

#include <cstdint>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/deviation_search.h"

namespace octavo {

struct LimitedSurface {
  bool is_reached = false;  ///< else there is no mesh
  /// Of the surface, or where the limit was not reached of the one that has fewest.
  std::uint64_t triangle_count = 0;
  TriangleMesh mesh;
  double max_deviation_mm = 0;  ///< proven, in both directions
  std::uint64_t crossing_triangles = 0;
};

/// Decimates to `limit` triangles or fewer: within half the shortest side of a voxel where that
/// does, else as near to the limit as deviation_search.h comes within a few percent.
/// Requires a closed manifold. Uses the threads of the calling task arena.
/// Throws  as decimate
/// Memory  that of decimate, and 80 bytes per triangle of the surface within half a voxel
LimitedSurface decimate_to(const TriangleMesh& full, std::uint64_t limit,
                           const Geometry& geometry, Progress& progress);

/// The same of a surface of `full_count` triangles, of which `first` is what first_step_mm of
/// deviation left. Its deviation is what the search proves.
LimitedSurface decimate_to(const TriangleMesh& first, std::uint64_t full_count,
                           std::uint64_t limit, const Geometry& geometry, Progress& progress);

/// The search that decimate_to makes: from half a voxel on, as far as a surface reaches.
DeviationSearch search_to(std::uint64_t limit, const TriangleMesh& full, const Geometry& geometry);

/// For rounding, added to deviations that are measured.
double measuring_margin_mm(const Geometry& geometry);

/// Triangles that a surface needs at the fewest: four for each of its pieces.
std::uint64_t fewest_possible(const TriangleMesh& full);

}  // namespace octavo
