// Neighbors in a linear octree: what lies beside a cube in one of 26 directions.
//
// The code of the neighbor of the same size follows from the code by carries on the spread bits of
// each axis. The leaf over it has that code with digits cut off, so it is searched level by level
// from the cube's own level up, in the sorted list of each. No coordinates are made.
//
// Source  thesis 4.6, 4.7
#pragma once

#include <array>
#include <cstdint>

#include "octavo/octree/linear_octree.h"

namespace octavo {

enum class NeighborKind : std::uint8_t {
  outside,     ///< beyond the universe
  background,  ///< no leaf there
  smaller,     ///< leaves smaller than the cube, at least one
  leaf         ///< one leaf of the same or a larger size
};

struct Neighbor {
  NeighborKind kind = NeighborKind::outside;
  Leaf leaf;  ///< when kind is leaf

  bool operator==(const Neighbor&) const = default;
};

/// What fills the place of `cube`: one leaf of its size or larger, smaller leaves, or background.
/// Requires a linear octree with the cube in its universe. O(n log L), thread-safe
Neighbor leaf_at(const LinearOctree& octree, const OCode& cube);

/// What lies beside `cube` in `direction`; the cube need not be a leaf.
/// Requires a linear octree with the cube in its universe. O(n log L), thread-safe
Neighbor neighbor_in(const LinearOctree& octree, const OCode& cube, const Direction& direction);

/// The same in the order of kDirections.
std::array<Neighbor, 26> neighbors_in(const LinearOctree& octree, const OCode& cube);

}  // namespace octavo
