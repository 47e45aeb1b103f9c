// A mesh whose points lie on a grid, where that does it no harm.
#pragma once

#include <optional>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/formats/point_grid.h"

namespace octavo {

/// The mesh with every point moved to the place of the grid nearest to it; nothing where points
/// come to lie on others, triangles cross, or a piece loses its inside.
/// Requires a mesh without such faults. Uses the threads of the calling task arena.
/// Throws  Error{cancelled}
/// Memory  about 100 bytes per point
std::optional<TriangleMesh> mesh_on_grid(const TriangleMesh& mesh, const PointGrid& grid,
                                         const Progress& progress);

}  // namespace octavo
