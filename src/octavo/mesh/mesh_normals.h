// Normals of the points of a surface: unit vectors away from the inside, for smooth shading.
#pragma once

#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/file/reader.h"
#include "octavo/mesh/surface_field.h"

namespace octavo {

/// Of each point the mean of the normals of its triangles, weighted by their areas; along z
/// where these have no area or cancel.
std::vector<MeshPoint> area_normals(const TriangleMesh& mesh);

/// Of each point that against the gradient of the grey values there: central differences over a
/// voxel to either side, interpolated between voxels, in world space. As area_normals where there
/// is no gradient: at the border of the volume, beside NaN, where values are flat or fall to the
/// other side.
/// mesh   a surface of a level of the reader; its points need not be those of the full surface
/// field  of grey values; of labels the result is that of area_normals
/// Uses the threads of the calling task arena; the result does not depend on them.
/// Throws  what the reader throws, Error{cancelled}
/// Memory  60 bytes per point, and 1.3 MB per thread; besides the reader's cache
std::vector<MeshPoint> gradient_normals(const TriangleMesh& mesh, const FileReader& reader,
                                        int level, const SurfaceField& field, Progress& progress);

}  // namespace octavo
