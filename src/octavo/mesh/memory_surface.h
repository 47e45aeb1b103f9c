// The surface of what lies inside, of voxels in memory.
//
// Each row of voxels is a row of bits, padded by what lies outside:
//
//     bits     1 a voxel, rows of 64-bit words           made, plane by plane
//     numbers  3 a row: of the first point on edges      counted, then summed up
//              along x, y and z
//     points, triangles                                  written by the bits, a plane at a time
//
// Points stand by the voxels at which their edges end, row by row; of a row first those on edges
// along x, then y, then z.
#pragma once

#include <cstdint>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/core/volume.h"
#include "octavo/mesh/surface_field.h"

namespace octavo {

/// Voxels [z][y][x], of the type and size that the description says.
struct VoxelsInMemory {
  const void* voxels = nullptr;
  VoxelType type = VoxelType::uint8;
  Size3 size;
  Geometry geometry;
};

/// The surface that extract_surface gives of a file with these voxels: the same points, joined
/// alike, in the order above. Uses the threads of the calling task arena; the result does not
/// depend on them.
/// Throws  Error{cancelled}; Error{limit_exceeded} for 2^32 points or more
/// Memory  that of the surface; a bit for each voxel, 12 bytes for each row of them
TriangleMesh surface_of(const VoxelsInMemory& volume, const SurfaceField& field,
                        Progress& progress);

}  // namespace octavo
