// The proof that one surface lies within a distance of another, triangle by triangle.
//
// Distance to a triangle is a convex function. So all of a triangle a, b, c lies within a distance
// of the other surface where one triangle of that lies within it of a, b and c. Where none does, a
// triangle is cut into four, down to 1/64 of its sides. Nothing is sampled: what is not proven
// counts as too far.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo {

/// Triangles of `mesh` that are not proven to lie within `distance` of the surface of `tree`,
/// ascending. Uses the threads of the calling task arena.
/// hints     of each point of the mesh: a triangle of the tree that may be near, or
///           TriangleTree::kNone; empty: none
/// progress  is asked whether to stop, and told nothing
/// Throws  Error{cancelled}
std::vector<std::uint32_t> unproven_triangles(const TriangleMesh& mesh, const TriangleTree& tree,
                                              double distance, const Progress& progress,
                                              std::span<const std::uint32_t> hints = {});

}  // namespace octavo
