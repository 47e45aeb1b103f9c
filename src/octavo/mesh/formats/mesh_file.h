// Surfaces in the formats of other programs: STL, PLY and OBJ.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/core/triangle_mesh.h"
#include "octavo/file/storage/pending_file.h"

namespace octavo {

enum class MeshFormat { stl, ply, obj };

/// By the ending of a name, in letters of either case.
std::optional<MeshFormat> mesh_format_of(const std::string& path);

/// ".stl, .ply or .obj"
const char* mesh_format_endings();

/// Axes of the coordinates that are written. DICOM, ITK and Octavo have x to the left and y to the
/// back; FreeSurfer, NIfTI and the MNI space have both turned round.
enum class MeshSpace { lps, ras };

/// Appends a surface to a file, mm. Binary but for OBJ; STL says its space as 3D Slicer does.
/// comments  lines that PLY and OBJ carry
/// Throws  as PendingFile; Error{limit_exceeded} for more points or triangles than the format can
///         number
/// Memory  a buffer of a megabyte
void write_mesh(const TriangleMesh& mesh, MeshFormat format, MeshSpace space,
                const std::vector<std::string>& comments, PendingFile& file);

}  // namespace octavo
