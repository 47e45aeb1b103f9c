// The linear octree: the leaves of an octree and nothing else, one sorted list of codes per level.
//
// Invariants
//   levels[k].codes is strictly ascending; levels[k].values[i] belongs to levels[k].codes[i].
//   Leaves are disjoint: no leaf lies inside another.
//   Leaves cover the object exactly. What no leaf covers is background, or outside the volume.
// Consequences
//   L leaves cost L codes, where a tree with pointers costs 8(L-1)/7 nodes.
//   The leaf over a voxel is found by cutting digits off the voxel's code and searching one list
//   per level; at most one search succeeds.
//   The volume of the object is the sum of count * 8^k: no traversal of the space is needed.
//   Two octrees over the same universe hold the same object when their lists are equal, provided
//   both are condensed (no eight sibling leaves are homogeneous).
//
// This is the reference form: printed, exported, compared, searched. Code that asks for single
// voxels millions of times uses a brick instead.
//
// Source  thesis 2.3 (linear hierarchical order)
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "octavo/octree/o_code.h"

namespace octavo {

struct LinearOctree {
  struct Level {
    std::vector<std::uint64_t> codes;
    std::vector<std::int64_t> values;
    bool operator==(const Level&) const = default;
  };

  int root_level = 0;         ///< n: the universe has side 2^n
  std::vector<Level> levels;  ///< n + 1 lists, level 0 first

  bool operator==(const LinearOctree&) const = default;
};

/// A leaf with its value.
struct Leaf {
  OCode cube;
  std::int64_t value = 0;
  bool operator==(const Leaf&) const = default;
};

/// An octree of root level n without leaves. Requires 0 <= n <= 21.
LinearOctree empty_octree(int n);

/// Leaves of one level.
std::int64_t leaf_count(const LinearOctree& octree, int level);

/// Leaves of all levels.
std::int64_t leaf_count(const LinearOctree& octree);

/// Voxels under the leaves of all levels, overlaps counted twice.
std::uint64_t leaf_volume(const LinearOctree& octree);

/// True when there are n + 1 lists, a value for each code, every code lies in the universe and
/// every list is strictly ascending.
bool is_sorted(const LinearOctree& octree);

/// True when the octree is sorted and no leaf lies inside another.
/// Memory  24 bytes per leaf; O(L log L)
bool is_linear(const LinearOctree& octree);

/// True when the octree is linear and its leaves have the volume of the object, `object_volume`
/// voxels. With leaves known to lie inside the object this means that they cover it.
bool is_complete(const LinearOctree& octree, std::uint64_t object_volume);

/// The leaf over a voxel; nothing for background and outside the universe. O(n log L)
std::optional<Leaf> find_leaf(const LinearOctree& octree, const Index3& voxel);

/// All leaves in post-order (that of the mixed-octal strings).
std::vector<Leaf> leaves_in_post_order(const LinearOctree& octree);

}  // namespace octavo
