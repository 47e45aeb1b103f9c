#include "octavo/tasks/surfaces/reduced_mesh.h"

#include <fmt/format.h>

#include <utility>

#include "octavo/core/error.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/decimation_steps.h"
#include "octavo/mesh/formats/grid_mesh.h"
#include "octavo/mesh/octree_decimation/octree_decimation.h"
#include "octavo/mesh/triangle_limit.h"

namespace octavo {

namespace {

/// A grid for what lies within the deviation of a mesh; nothing where its steps take much of that.
std::optional<PointGrid> grid_within(const TriangleMesh& mesh, double deviation_mm) {
  constexpr double kShare = 0.25;
  const PointGrid grid = PointGrid::around(mesh, deviation_mm);
  if (grid.largest_move_mm() > kShare * deviation_mm) return std::nullopt;
  return grid;
}

}  // namespace

void require_reducible(const TriangleMesh& mesh, const TaskContext& context) {
  require_numbered(mesh.triangles.size());
  constexpr std::uint64_t kBytesPerPoint = 600;
  context.require_memory(kBytesPerPoint * mesh.points.size(), "the surface");
}

std::optional<PointGrid> reduce_mesh(DecimationMethod method, TriangleMesh& mesh,
                                     const Geometry& geometry, bool wants_grid,
                                     const TaskContext& context, SurfaceResult& result) {
  require_reducible(mesh, context);
  const double deviation = result.max_deviation_mm;
  std::optional<PointGrid> grid;
  if (wants_grid) grid = grid_within(mesh, deviation);
  if (grid) result.max_deviation_mm -= grid->largest_move_mm();
  Decimated reduced;
  std::optional<TriangleMesh> moved;
  context.on_threads([&] {
    const auto reduce = method == DecimationMethod::cells ? decimate_by_cells : decimate_in_steps;
    reduced = reduce(mesh, {result.max_deviation_mm, geometry}, context.watcher());
    if (!grid || reduced.crossing_triangles > 0) return;
    moved = mesh_on_grid(reduced.mesh, *grid, context.watcher());
  });
  result.crossing_triangles = reduced.crossing_triangles;
  if (moved) result.max_deviation_mm = deviation;
  else grid.reset();
  mesh = moved ? *std::move(moved) : std::move(reduced.mesh);
  return grid;
}

std::optional<PointGrid> reduce_mesh_to(std::uint64_t limit, TriangleMesh& mesh,
                                        const Geometry& geometry, bool wants_grid,
                                        const TaskContext& context, SurfaceResult& result) {
  require_reducible(mesh, context);
  const std::uint64_t fewest = fewest_possible(mesh);
  if (limit < fewest) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("no surface of {} pieces has at most {} triangles: each piece needs "
                            "four, {} together",
                            fewest / 4, limit, fewest))
        .with_field("surface.triangles");
  }
  LimitedSurface limited;
  std::optional<PointGrid> grid;
  std::optional<TriangleMesh> moved;
  context.on_threads([&] {
    limited = decimate_to(mesh, limit, geometry, context.watcher());
    if (!limited.is_reached || !wants_grid || limited.crossing_triangles > 0) return;
    grid = grid_within(limited.mesh, limited.max_deviation_mm);
    if (grid) moved = mesh_on_grid(limited.mesh, *grid, context.watcher());
  });
  if (!limited.is_reached) reject_limit(limit, limited.triangle_count);
  result.crossing_triangles = limited.crossing_triangles;
  result.max_deviation_mm = limited.max_deviation_mm;
  if (moved) result.max_deviation_mm += grid->largest_move_mm();
  else grid.reset();
  mesh = moved ? *std::move(moved) : std::move(limited.mesh);
  return grid;
}

void reject_limit(std::uint64_t limit, std::uint64_t fewest) {
  throw Error(ErrorKind::invalid_argument,
              fmt::format("the surface cannot be made of {} triangles: its pieces and handles "
                          "stay, and {} are the fewest that were reached",
                          limit, fewest))
      .with_field("surface.triangles");
}

}  // namespace octavo
