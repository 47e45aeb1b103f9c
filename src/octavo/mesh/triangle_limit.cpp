#include "octavo/mesh/triangle_limit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "octavo/mesh/decimation_frame.h"
#include "octavo/mesh/decimation_steps.h"
#include "octavo/mesh/measured_deviation.h"
#include "octavo/mesh/mesh_pieces.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

namespace {

double diagonal_of(const TriangleMesh& mesh) {
  SpaceBox box;
  for (const MeshPoint& point : mesh.points) box.add(point);
  return std::hypot(box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]);
}

/// What the search finds from a surface on; its deviation is the sum of the steps.
template <class Reduce>
LimitedSurface searched(const TriangleMesh& start, std::uint64_t limit, const Geometry& geometry,
                        const Reduce& reduce, Progress& progress) {
  DeviationSearch search = search_to(limit, start, geometry);
  auto found = searched_surface(search, start, reduce,
                                [](const TriangleMesh& mesh) { return mesh.triangles.size(); });
  LimitedSurface limited;
  limited.triangle_count = search.fewest();
  if (!found) return limited;
  limited.is_reached = true;
  limited.mesh = std::move(found->first);
  limited.triangle_count = limited.mesh.triangles.size();
  limited.max_deviation_mm = found->second;
  limited.crossing_triangles =
      crossing_triangles(TriangleTree(limited.mesh), progress).size();
  return limited;
}

}  // namespace

DeviationSearch search_to(std::uint64_t limit, const TriangleMesh& full,
                          const Geometry& geometry) {
  return {limit, first_step_mm(geometry), diagonal_of(full)};
}

LimitedSurface decimate_to(const TriangleMesh& full, std::uint64_t limit,
                           const Geometry& geometry, Progress& progress) {
  const auto reduce = [&](const TriangleMesh& base, double deviation) {
    return decimate_further(base, full.triangles.size(), deviation, geometry, progress).mesh;
  };
  LimitedSurface limited = searched(full, limit, geometry, reduce, progress);
  if (!limited.is_reached) return limited;
  if (limited.triangle_count == full.triangles.size()) {
    limited.max_deviation_mm = 0;
    return limited;
  }
  limited.max_deviation_mm =
      measured_deviation(full, limited.mesh, limited.max_deviation_mm,
                         measuring_margin_mm(geometry), progress);
  return limited;
}

LimitedSurface decimate_to(const TriangleMesh& first, std::uint64_t full_count,
                           std::uint64_t limit, const Geometry& geometry, Progress& progress) {
  bool is_first = true;
  const auto reduce = [&](const TriangleMesh& base, double deviation) {
    if (std::exchange(is_first, false)) return first;
    return decimate_further(base, full_count, deviation, geometry, progress).mesh;
  };
  LimitedSurface limited = searched(first, limit, geometry, reduce, progress);
  if (limited.is_reached && limited.triangle_count == full_count) limited.max_deviation_mm = 0;
  return limited;
}

double measuring_margin_mm(const Geometry& geometry) {
  constexpr double kMargin = 1e-5;
  return kMargin * shortest_side(geometry);
}

std::uint64_t fewest_possible(const TriangleMesh& full) { return 4 * mesh_pieces(full).count; }

}  // namespace octavo
