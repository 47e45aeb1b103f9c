// What is known of a surface that was made, for programs: in a file of its own, in the mesh, and
// on the screen.
#pragma once

#include "octavo/core/json_text.h"
#include "octavo/tasks/surface.h"

namespace octavo {

/// Everything but where the surface went. Lengths, areas and volumes are null where the spacing of
/// the volume is not known, and self_intersections where they were not counted: a surface with all
/// its triangles has none.
JsonObject surface_report(const SurfaceOptions& options, const SurfaceResult& result);

}  // namespace octavo
