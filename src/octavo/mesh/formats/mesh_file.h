// Surfaces in the formats of other programs.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/mesh/formats/mesh_description.h"

namespace octavo {

enum class MeshFormat { stl, ply, obj, glb, vtp, three_mf };

/// By the ending of a name, in letters of either case.
std::optional<MeshFormat> mesh_format_of(const std::string& path);

/// ".stl, .ply, .obj, .glb, .vtp or .3mf"
const char* mesh_format_endings();

/// Whether files of a format have a normal of each point.
bool has_normals(MeshFormat format);

/// Throws Error{limit_exceeded} that names `path` where a format cannot hold a label: those of PLY
/// have 32 bits
void require_label(MeshFormat format, std::int64_t label, const std::string& path);

/// Appends a surface to a file, as mesh_formats.h says of each format.
/// watcher  ends it within a megabyte, of GLB within an array of a part
/// Throws  as PendingFile and require_label; Error{cancelled}; Error{limit_exceeded} for more
///         points or triangles than the format can number
/// Memory  a buffer of a megabyte; 3MF 8 bytes per point; GLB as much as the file, and
///         about 100 bytes per point of a part
void write_mesh(const MeshDescription& mesh, MeshFormat format, const Progress& watcher,
                PendingFile& file);

}  // namespace octavo
