// A surface with few triangles that is proven to lie within a distance of the full one, and the
// full one within that distance of it.
//
// Triangles are cut into parts, cubes of 32 voxels or as asked, whose edges are collapsed
// (collapse.h); points that parts share stay. A second pass, its cubes shifted by half their side,
// takes those. Then both distances are proven (certificate.h), and that no triangles cross and no
// piece is turned inside out. Where that fails the points around get a smaller tolerance, in the
// end none, and all is done again where it could come out otherwise: since the full surface
// passes, this ends. Parts depend on nothing but their triangles, so the result does not depend on
// threads.
//
// Components, handles and closedness stay as they are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"

namespace octavo {

enum class DecimationMethod {
  collapse,  ///< edges are collapsed in the order of their costs
  cells      ///< cells of an octree merge (octree_decimation.h)
};

struct DecimationOptions {
  double max_deviation_mm = 0;  ///< above 0
  Geometry geometry;            ///< of the grid that the surface was taken from
  /// Points of the full surface that stay where they are.
  std::span<const std::uint32_t> locked = {};
  /// Of the cubes that the surface is cut into, in voxels; above 0.
  double part_side = 32;
};

struct Decimated {
  TriangleMesh mesh;
  int rounds = 0;  ///< that it took
  /// Triangles that cross others: of a full surface without any, none.
  std::uint64_t crossing_triangles = 0;
  /// Numbers in the mesh of the locked points, in their order.
  std::vector<std::uint32_t> locked = {};
};

/// Requires a manifold that is closed, or ends at locked points; that no piece is turned inside out
/// is proven of those without locked points. Uses the threads of the calling task arena.
/// Throws  Error{cancelled}; as require_numbered
/// Memory  450 to 600 bytes per point of the full surface, and a part of it per thread
Decimated decimate(const TriangleMesh& full, const DecimationOptions& options,
                   Progress& progress);

/// Triangles have numbers of 32 bits. Throws Error{limit_exceeded} for more.
void require_numbered(std::uint64_t triangle_count);

}  // namespace octavo
