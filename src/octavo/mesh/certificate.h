// The proof that one surface lies within a distance of another, triangle by triangle.
//
// Distance to a triangle is a convex function. So all of a triangle a, b, c lies within a distance
// of the other surface where one triangle of that lies within it of a, b and c. Where none does, a
// triangle is cut in two at its longest side, up to 14 times. Nothing is sampled: what is not
// proven counts as too far.
//
// Any triangle that is near enough is a proof, not only the nearest. So triangles that are known to
// be near are tried first, and the tree is searched for what they do not prove. Most triangles of a
// reduced mesh are seen to be covered by the other surface (cover_proof.h), which is proof as well.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/point_triangles.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

/// Triangles that were proven by a search, each by triangles of the tree: as long as these are the
/// same, they prove it.
struct SearchedProofs {
  std::vector<std::uint32_t> proven;
  std::vector<std::size_t> ends;  ///< in `by`, behind those of each
  std::vector<std::uint32_t> by;

  std::span<const std::uint32_t> of(std::size_t number) const {
    const std::size_t first = number == 0 ? 0 : ends[number - 1];
    return {by.data() + first, ends[number] - first};
  }
};

/// Triangles of `mesh` that are not proven to lie within `distance` of the surface of `tree`,
/// ascending. Uses the threads of the calling task arena.
/// hints     of each point of the mesh: a triangle of the tree that may be near, or
///           TriangleTree::kNone; empty: none
/// is_known  of each triangle, or empty: where not 0 it is known to be proven; set to 1 where
///           nothing but the triangles that its hints name proved it
/// searched  takes the others that are proven; or nullptr
/// progress  is asked whether to stop, and told nothing
/// Throws  Error{cancelled}
std::vector<std::uint32_t> unproven_triangles(const TriangleMesh& mesh, const TriangleTree& tree,
                                              double distance, const Progress& progress,
                                              std::span<const std::uint32_t> hints = {},
                                              std::span<std::uint8_t> is_known = {},
                                              SearchedProofs* searched = nullptr);

/// Points of the other surface that lie near triangles of a mesh, as lists.
struct AttachedPoints {
  std::vector<std::uint32_t> first;  ///< of each triangle of the mesh; TriangleTree::kNone
  std::vector<std::uint32_t> next;   ///< of each point of the other surface; TriangleTree::kNone
};

/// What is known of a mesh and the other surface.
struct KnownNearby {
  const AttachedPoints& attached;
  const PointTriangles& mesh_fans;
  const PointTriangles& other_fans;
};

/// The same for some triangles of a mesh, `triangles`, ascending, with points attached to it.
std::vector<std::uint32_t> unproven_triangles(const TriangleMesh& mesh,
                                              std::span<const std::uint32_t> triangles,
                                              const TriangleTree& tree, double distance,
                                              const KnownNearby& known, const Progress& progress);

}  // namespace octavo
