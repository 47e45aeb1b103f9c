// A surface with fewer triangles, as a deviation or a number of them asks, and where its file keeps
// points on a grid, with those moved there.
#pragma once

#include <cstdint>
#include <optional>

#include "octavo/core/error.h"
#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/formats/point_grid.h"
#include "octavo/mesh/layered_decimation/layered_decimation.h"
#include "octavo/tasks/surface.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Proves that the triangles of a mesh can be numbered, and that taking some away fits into memory.
/// Throws  as require_numbered and TaskContext::require_memory
void require_reducible(const TriangleMesh& mesh, const TaskContext& context);

/// What is reduced of a surface while it is extracted (layered_decimation.h).
struct ExtractedReduction {
  double max_deviation_mm = 0;  ///< 0: nothing
  std::optional<PointGrid> grid;  ///< that points are moved to in the end
};

/// That of a level of some voxels, as the deviation of the result or a number of triangles asks.
ExtractedReduction reduction_while_extracted(const SurfaceOptions& options,
                                             const Geometry& geometry, const Size3& size,
                                             bool wants_grid, const SurfaceResult& result);

/// Takes triangles away as far as the deviation of the result allows, less what moving points to a
/// grid takes; sets what the result says of triangles that cross.
/// surface  the full one, or what `done` left of it
/// Returns the grid that the points lie on in the end, if any
std::optional<PointGrid> reduce_mesh(DecimationMethod method, LayeredSurface& surface,
                                     const ExtractedReduction& done, const Geometry& geometry,
                                     bool wants_grid, const TaskContext& context,
                                     SurfaceResult& result);

/// Takes triangles away until there are `limit` or fewer; sets the deviation of the result as well.
/// Throws Error{invalid_argument} where the surface cannot be made of so few
std::optional<PointGrid> reduce_mesh_to(std::uint64_t limit, LayeredSurface& surface,
                                        const Geometry& geometry, bool wants_grid,
                                        const TaskContext& context, SurfaceResult& result);

/// What is wrong where a surface cannot be made of so few triangles.
Error unreached_limit(std::uint64_t limit, std::uint64_t fewest);

}  // namespace octavo
