// Surfaces between labels with fewer triangles, all of them proven to lie within a distance of the
// full ones, and these of them.
//
// Each surface between two labels is decimated by itself (decimation.h). Lines where it meets
// others stay as they are, and so does what lies around places at which a label touches itself:
// what two labels or three share stays shared, and parts fit as before. Where triangles of
// different surfaces cross that did not cross before, both are done again more closely, in the end
// not at all.
#pragma once

#include <cstdint>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/mesh/nets/interface_mesh.h"

namespace octavo {

struct DecimatedInterfaces {
  InterfaceMesh interfaces;
  /// Triangles that cross others: of full surfaces without any, none. Points that are smoothed each
  /// by itself let surfaces cross where voxels are thin.
  std::uint64_t crossing_triangles = 0;
};

/// geometry  of the grid that the net was taken from
/// Requires a deviation above 0. Uses the threads of the calling task arena.
/// Throws  as decimate
/// Memory  60 bytes per triangle, and that of decimate for as many surfaces between two labels as
///         there are threads
DecimatedInterfaces decimate_interfaces(const InterfaceMesh& full, double max_deviation_mm,
                                        const Geometry& geometry, Progress& progress);

struct LimitedInterfaces {
  bool is_reached = false;  ///< else there are no interfaces
  /// Of them, or where the limit was not reached of those that have fewest.
  std::uint64_t triangle_count = 0;
  DecimatedInterfaces reduced;
  double max_deviation_mm = 0;  ///< proven, in both directions, of each surface between two labels
};

/// Decimates to `limit` triangles or fewer, as decimate_to (triangle_limit.h).
/// Memory  that of decimate_interfaces, and 110 bytes per triangle
LimitedInterfaces decimate_interfaces_to(const InterfaceMesh& full, std::uint64_t limit,
                                         const Geometry& geometry, Progress& progress);

}  // namespace octavo
