// The rounds of a decimation: two passes over the parts of a surface, proofs, smaller tolerances
// where these fail, and again (decimation.h).
//
// A surface may have fewer triangles in places already, proven before: the window of a surface that
// is longer (layered_decimation/layered_decimation.h). Its points are then attached to those.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/certificate.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/decimation_frame.h"

namespace octavo {

/// A surface with fewer triangles. Its points have the numbers of those of the full surface, some
/// are moved, and many are points of no triangle.
struct AttachedSurface {
  TriangleMesh mesh;
  /// Of each point of the full surface: a triangle that it lies near; TriangleTree::kNone: none.
  std::vector<std::uint32_t> nearest;
};

/// What rounds begin with, which is proven already.
struct DecimationStart {
  AttachedSurface surface;
  /// Its first triangles are fewer than those of the full surface; the others are of it.
  std::size_t reduced_count = 0;
};

/// What became of a surface, and why each triangle of the full one is near it.
struct DecimationProof {
  AttachedSurface surface;
  int rounds = 0;
  bool is_proven = false;  ///< else nothing is known of the surface
  std::uint64_t crossing_triangles = 0;
  /// Triangles of the full surface that those prove which their points are attached to.
  std::vector<std::uint8_t> is_by_attached;
  SearchedProofs searched;  ///< the others
};

/// Requires what decimate does; frame: of the same surface and options, and more than a margin of
/// deviation.
/// start  nothing: the full surface
/// Throws  Error{cancelled}
DecimationProof decimate_in_rounds(const TriangleMesh& full, const DecimationOptions& options,
                                   const DecimationFrame& frame, const DecimationStart* start,
                                   Progress& progress);

}  // namespace octavo
