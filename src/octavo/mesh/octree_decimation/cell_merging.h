// Cells of an octree that merge: what a surface has of points in a cell becomes one point.
//
// Cells are cubes of 2^k voxels. From the smallest up, points of a cell that hang together become
// one where
//   the surface keeps its topology: they and what lies between them can shrink to a point, around
//   which the triangles beside them make one fan,
//   no normal turns by more than about 78 degrees and no triangle becomes a sliver,
//   all points attached to the triangles around lie within their tolerance of a new one.
// Pieces of surface in the same cell merge each for themselves. A triangle with points in cells of
// different sizes ends at the points of both, so there are no cracks to be patched: sides of small
// cells lead to the point of the large one beside them.
//
// Source  thesis 4.2; Shekhar et al., Octree-based decimation of marching cubes surfaces, 1996;
//         Schaefer, Ju and Warren, Manifold dual contouring, 2007
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/quadric.h"

namespace octavo {

/// A surface whose cells merge. Points and triangles keep their numbers.
struct CellSurface {
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr int kLevels = 6;  ///< of cells: sides of 1 to 32 voxels

  std::vector<Point3> places;           // of points
  std::vector<Quadric> quadrics;        // of points
  std::vector<std::uint32_t> owners;    // of points: the one they became, or themselves
  std::vector<std::int8_t> levels;      // of points: that their cells merged at; -1: none
  std::vector<std::uint32_t> fans;      // of points: one of their triangles
  std::vector<MeshTriangle> triangles;
  std::vector<MeshTriangle> across;     // triangles at the side from corner k to the one behind
  std::vector<std::uint8_t> is_left;    // triangles that have not vanished
  std::vector<std::uint32_t> first;     // of triangles: the first full point attached
  std::vector<std::uint32_t> next;      // of full points: the next one attached to the same
};

/// What cells may do, the same for all.
struct CellRules {
  std::vector<Point3> full_places;        // of full points
  std::vector<std::uint64_t> codes;       // of full points: the o-code of the smallest cell
  std::vector<std::uint8_t> is_locked;    // full points that stay
  /// Cells of each level that stay as they are: ascending o-codes.
  std::array<std::vector<std::uint64_t>, CellSurface::kLevels> kept;
  double tolerance = 0;                   // of attached points
};

/// Merges cells of all levels. Uses the threads of the calling task arena; the result does not
/// depend on them.
void merge_cells(CellSurface& surface, const CellRules& rules);

}  // namespace octavo
