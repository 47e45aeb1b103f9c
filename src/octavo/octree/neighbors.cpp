#include "octavo/octree/neighbors.h"

#include <algorithm>
#include <optional>

namespace octavo {

namespace {

// True when a leaf of a lower level lies inside the cube: its codes are one run of each list.
bool has_smaller_leaf(const LinearOctree& octree, const OCode& cube) {
  for (int k = 0; k < cube.level; ++k) {
    const std::vector<std::uint64_t>& codes = octree.levels[static_cast<std::size_t>(k)].codes;
    const std::uint64_t count = cube_volume(cube.level - k);
    const auto first = std::lower_bound(codes.begin(), codes.end(), cube.code * count);
    if (first != codes.end() && *first < (cube.code + 1) * count) return true;
  }
  return false;
}

}  // namespace

Neighbor leaf_at(const LinearOctree& octree, const OCode& cube) {
  for (int k = cube.level; k <= octree.root_level; ++k) {
    const LinearOctree::Level& level = octree.levels[static_cast<std::size_t>(k)];
    const OCode over = ancestor_of(cube, k);
    const auto at = std::lower_bound(level.codes.begin(), level.codes.end(), over.code);
    if (at == level.codes.end() || *at != over.code) continue;
    const std::int64_t value = level.values[static_cast<std::size_t>(at - level.codes.begin())];
    return {NeighborKind::leaf, {over, value}};
  }
  return {has_smaller_leaf(octree, cube) ? NeighborKind::smaller : NeighborKind::background, {}};
}

Neighbor neighbor_in(const LinearOctree& octree, const OCode& cube, const Direction& direction) {
  const std::optional<OCode> beside = neighbor_of(cube, direction, octree.root_level);
  return beside ? leaf_at(octree, *beside) : Neighbor();
}

std::array<Neighbor, 26> neighbors_in(const LinearOctree& octree, const OCode& cube) {
  std::array<Neighbor, 26> neighbors;
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    neighbors[i] = neighbor_in(octree, cube, kDirections[i]);
  }
  return neighbors;
}

}  // namespace octavo
