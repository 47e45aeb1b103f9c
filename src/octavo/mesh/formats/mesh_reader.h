// Surfaces that other programs wrote: STL and PLY, of bytes or of text, and OBJ.
//
// | what is wrong | error |
// |---|---|
// | no file of the format, a number that is none, a corner that is no point | corrupt |
// | the file ends before what it announces | truncated |
// | no triangle in it | source_rejected |
// | points that are not finite, or beyond kFarthestPointMm | source_rejected |
// | more points than a number of 32 bits counts, more memory than allowed | limit_exceeded |
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "octavo/core/bytes.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/formats/mesh_description.h"
#include "octavo/mesh/formats/mesh_file.h"

namespace octavo {

/// No coordinate is larger, of either sign.
inline constexpr float kFarthestPointMm = 1e9f;

struct MeshReading {
  TriangleMesh mesh;                     ///< coordinates as they stand in the file
  std::optional<MeshSpace> space = {};   ///< where the file says "SPACE=RAS" or "SPACE=LPS"
};

/// Whether read_mesh knows a format: stl, ply, obj.
bool is_mesh_readable(MeshFormat format);

/// ".stl, .ply or .obj"
const char* readable_mesh_endings();

/// Reads a mesh. Polygons become triangles, concave ones as well (polygon_triangles.h); points of
/// STL that are equal become one.
/// most_bytes  of memory for the mesh and what reading it takes, besides `bytes`
/// Requires a format that is_mesh_readable.
/// Throws  as the table above says
/// Memory  at most 2 times the mesh, and 8 bytes per corner of STL
MeshReading read_mesh(ByteSpan bytes, MeshFormat format, std::uint64_t most_bytes);

/// Reads a PLY whose points need no triangles between them.
/// Throws  as read_mesh; Error{source_rejected} without points
MeshReading read_point_ply(ByteSpan bytes, std::uint64_t most_bytes);

/// Turns the mesh of a file that says RAS to LPS; that of any other is left as LPS.
void turn_to_lps(MeshReading& reading);

}  // namespace octavo
