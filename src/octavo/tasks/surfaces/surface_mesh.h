// The surface of what lies inside, in memory.
#pragma once

#include <optional>
#include <string>

#include "octavo/core/triangle_mesh.h"
#include "octavo/file/reader.h"
#include "octavo/mesh/formats/point_grid.h"
#include "octavo/mesh/surface_field.h"
#include "octavo/tasks/surface.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct SurfaceMesh {
  TriangleMesh mesh;
  SurfaceResult result;           ///< all but what is said of files
  std::optional<PointGrid> grid;  ///< that the points lie on
};

/// What is inside of a surface. Throws Error{invalid_argument} for labels that are not there
SurfaceField surface_field_of(const SurfaceOptions& options, const VolumeDescription& volume);

/// What lies inside, in words: "226 HU or more", "a label that was asked for".
std::string surface_inside_words(const SurfaceOptions& options, const VolumeDescription& volume);

/// The surface that `surface` writes, checked and measured.
/// options     their input names `reader` in errors; their output and report are not looked at
/// wants_grid  the points of a surface with fewer triangles lie on a grid
/// Throws  as surface does, files apart
/// Memory  as surface
SurfaceMesh surface_mesh(const FileReader& reader, const SurfaceOptions& options, bool wants_grid,
                         const TaskContext& context);

}  // namespace octavo
