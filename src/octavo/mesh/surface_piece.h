// Surface tracking: the one piece of a surface that a seed lies at, from block to block.
//
// It begins with the blocks around the seed. A block is made when a piece of the surface that the
// seed's is known to belong to has a point on an edge of one of its cubes:
//
//      +-------+-------+-------+
//      |       |   __.-+-.     |     bricks that the piece does not pass are not decoded,
//      |  .-.  | seed  |  \    |     even where another one passes them
//      +--(-)--+-------+---\---+
//
// Source  thesis 4.1
#pragma once

#include <cstdint>
#include <optional>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/file/reader.h"
#include "octavo/mesh/surface_field.h"

namespace octavo {

struct SurfacePiece {
  TriangleMesh mesh;
  std::uint64_t decoded_bricks = 0;
};

/// The piece of the surface of a level that comes nearest to a place, within the diagonal of a
/// voxel of it; nothing where no surface does. Points and triangles are those of
/// extract_surface, in their order. Uses the threads of the calling task arena; the result does not
/// depend on them.
/// seed       in voxels of the level, among them
/// max_bytes  of the mesh; 0: no limit
/// Throws  what the reader throws, Error{cancelled}; Error{limit_exceeded} beyond max_bytes or for
///         3 * 2^30 points or more
/// Memory  that of the piece; 150 kB for each block of 64^3 voxels that it passes
std::optional<SurfacePiece> surface_piece(const FileReader& reader, int level,
                                          const SurfaceField& field, const Point3& seed,
                                          std::uint64_t max_bytes, Progress& progress);

}  // namespace octavo
