#include "octavo/tasks/surfaces/reduced_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/decimation_steps.h"
#include "octavo/mesh/formats/grid_mesh.h"
#include "octavo/mesh/octree_decimation/octree_decimation.h"
#include "octavo/mesh/surface_frame.h"
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

/// The corners of what the voxels of a level and a surface around them fill, as points of a mesh.
TriangleMesh box_around(const SurfaceFrame& frame) {
  TriangleMesh box;
  const Size3& size = frame.size();
  for (const std::int64_t z : {std::int64_t{-1}, size.z}) {
    for (const std::int64_t y : {std::int64_t{-1}, size.y}) {
      for (const std::int64_t x : {std::int64_t{-1}, size.x}) {
        box.points.push_back(frame.point_at(static_cast<double>(x), static_cast<double>(y),
                                            static_cast<double>(z)));
      }
    }
  }
  return box;
}

}  // namespace

void require_reducible(const TriangleMesh& mesh, const TaskContext& context) {
  require_numbered(mesh.triangles.size());
  constexpr std::uint64_t kBytesPerPoint = 600;
  context.require_memory(kBytesPerPoint * mesh.points.size(), "the surface");
}

ExtractedReduction reduction_while_extracted(const SurfaceOptions& options,
                                             const Geometry& geometry, const Size3& size,
                                             bool wants_grid, const SurfaceResult& result) {
  const double first = first_step_mm(geometry);
  if (options.triangles) return {first, std::nullopt};
  if (options.method != DecimationMethod::collapse) return {};
  ExtractedReduction reduction{result.max_deviation_mm, std::nullopt};
  if (wants_grid && reduction.max_deviation_mm > 0) {
    reduction.grid = grid_within(box_around(SurfaceFrame(geometry, size)),
                                 reduction.max_deviation_mm);
    if (reduction.grid) reduction.max_deviation_mm -= reduction.grid->largest_move_mm();
  }
  reduction.max_deviation_mm = std::min(reduction.max_deviation_mm, first);
  return reduction;
}

std::optional<PointGrid> reduce_mesh(DecimationMethod method, LayeredSurface& surface,
                                     const ExtractedReduction& done, const Geometry& geometry,
                                     bool wants_grid, const TaskContext& context,
                                     SurfaceResult& result) {
  TriangleMesh& mesh = surface.mesh;
  require_reducible(mesh, context);
  const double deviation = result.max_deviation_mm;
  std::optional<PointGrid> grid;
  if (surface.is_reduced) grid = done.grid;
  else if (wants_grid) grid = grid_within(mesh, deviation);
  if (grid) result.max_deviation_mm -= grid->largest_move_mm();
  Decimated reduced;
  std::optional<TriangleMesh> moved;
  context.on_threads([&] {
    const DecimationOptions asked = {result.max_deviation_mm, geometry};
    const auto reduce = method == DecimationMethod::cells ? decimate_by_cells : decimate_in_steps;
    if (surface.is_reduced) {
      reduced = decimate_in_further_steps(
          {std::move(mesh), 0, surface.crossing_triangles}, done.max_deviation_mm,
          surface.full_triangle_count, asked, context.watcher());
    } else {
      reduced = reduce(mesh, asked, context.watcher());
    }
    if (!grid || reduced.crossing_triangles > 0) return;
    moved = mesh_on_grid(reduced.mesh, *grid, context.watcher());
  });
  result.crossing_triangles = reduced.crossing_triangles;
  if (moved) result.max_deviation_mm = deviation;
  else grid.reset();
  mesh = moved ? *std::move(moved) : std::move(reduced.mesh);
  return grid;
}

std::optional<PointGrid> reduce_mesh_to(std::uint64_t limit, LayeredSurface& surface,
                                        const Geometry& geometry, bool wants_grid,
                                        const TaskContext& context, SurfaceResult& result) {
  TriangleMesh& mesh = surface.mesh;
  require_reducible(mesh, context);
  const std::uint64_t fewest = fewest_possible(mesh);
  if (limit < fewest) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("a surface of {} has {} triangles or more; the limit is {}",
                            counted_text(static_cast<std::int64_t>(fewest / 4), "piece"), fewest,
                            limit))
        .with_field("surface.triangles");
  }
  LimitedSurface limited;
  std::optional<PointGrid> grid;
  std::optional<TriangleMesh> moved;
  context.on_threads([&] {
    limited = surface.is_reduced
                  ? decimate_to(mesh, surface.full_triangle_count, limit, geometry,
                                context.watcher())
                  : decimate_to(mesh, limit, geometry, context.watcher());
    if (!limited.is_reached || !wants_grid || limited.crossing_triangles > 0) return;
    grid = grid_within(limited.mesh, limited.max_deviation_mm);
    if (grid) moved = mesh_on_grid(limited.mesh, *grid, context.watcher());
  });
  if (!limited.is_reached) {
    throw unreached_limit(limit, limited.triangle_count).with_field("surface.triangles");
  }
  result.crossing_triangles = limited.crossing_triangles;
  result.max_deviation_mm = limited.max_deviation_mm;
  if (moved) result.max_deviation_mm += grid->largest_move_mm();
  else grid.reset();
  mesh = moved ? *std::move(moved) : std::move(limited.mesh);
  return grid;
}

Error unreached_limit(std::uint64_t limit, std::uint64_t fewest) {
  return {ErrorKind::invalid_argument,
          fmt::format("pieces and handles stay: {} triangles are the fewest that were reached; the "
                      "limit is {}",
                      fewest, limit)};
}

}  // namespace octavo
