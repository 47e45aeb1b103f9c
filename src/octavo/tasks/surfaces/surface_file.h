// A surface as a file, and its report beside it.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/mesh/formats/mesh_file.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Writes both or none: a report stands at no moment beside another surface.
/// report_path  empty: no report
/// Returns the size of the surface's file
/// Throws  as write_mesh; Error{cancelled}
std::uint64_t write_surface(const MeshDescription& mesh, MeshFormat format, const Output& output,
                            const std::string& report_path, const TaskContext& context);

}  // namespace octavo
