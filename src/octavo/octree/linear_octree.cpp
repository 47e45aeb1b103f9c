#include "octavo/octree/linear_octree.h"

#include <algorithm>
#include <functional>

namespace octavo {

namespace {

bool is_strictly_ascending(const std::vector<std::uint64_t>& codes) {
  return std::adjacent_find(codes.begin(), codes.end(), std::greater_equal<>()) == codes.end();
}

}  // namespace

LinearOctree empty_octree(int n) {
  LinearOctree octree;
  octree.root_level = n;
  octree.levels.resize(static_cast<std::size_t>(n) + 1);
  return octree;
}

std::int64_t leaf_count(const LinearOctree& octree, int level) {
  return static_cast<std::int64_t>(octree.levels[static_cast<std::size_t>(level)].codes.size());
}

std::int64_t leaf_count(const LinearOctree& octree) {
  std::int64_t count = 0;
  for (int k = 0; k <= octree.root_level; ++k) count += leaf_count(octree, k);
  return count;
}

std::uint64_t leaf_volume(const LinearOctree& octree) {
  std::uint64_t volume = 0;
  for (int k = 0; k <= octree.root_level; ++k) {
    volume += static_cast<std::uint64_t>(leaf_count(octree, k)) * cube_volume(k);
  }
  return volume;
}

bool is_sorted(const LinearOctree& octree) {
  const int n = octree.root_level;
  if (n < 0 || n > kMaxUniverseLevel) return false;
  if (octree.levels.size() != static_cast<std::size_t>(n) + 1) return false;
  for (int k = 0; k <= n; ++k) {
    const LinearOctree::Level& level = octree.levels[static_cast<std::size_t>(k)];
    if (level.codes.size() != level.values.size()) return false;
    if (!is_strictly_ascending(level.codes)) return false;
    if (!level.codes.empty() && !is_valid(OCode{k, level.codes.back()}, n)) return false;
  }
  return true;
}

bool is_linear(const LinearOctree& octree) {
  if (!is_sorted(octree)) return false;
  // Cubes are nested or disjoint, so leaves sorted by their last voxel overlap only with a
  // neighbor.
  const std::vector<Leaf> leaves = leaves_in_post_order(octree);
  std::uint64_t end = 0;
  for (const Leaf& leaf : leaves) {
    const std::uint64_t first_voxel = leaf.cube.code * cube_volume(leaf.cube.level);
    if (first_voxel < end) return false;
    end = first_voxel + cube_volume(leaf.cube.level);
  }
  return true;
}

bool is_complete(const LinearOctree& octree, std::uint64_t object_volume) {
  return is_linear(octree) && leaf_volume(octree) == object_volume;
}

std::optional<Leaf> find_leaf(const LinearOctree& octree, const Index3& voxel) {
  const std::int64_t side = cube_side(octree.root_level);
  if (!Box{{0, 0, 0}, {side, side, side}}.contains(voxel)) return {};
  const OCode code = cube_at(voxel, 0);
  for (int k = 0; k <= octree.root_level; ++k) {
    const LinearOctree::Level& level = octree.levels[static_cast<std::size_t>(k)];
    const OCode cube = ancestor_of(code, k);
    const auto at = std::lower_bound(level.codes.begin(), level.codes.end(), cube.code);
    if (at != level.codes.end() && *at == cube.code) {
      return Leaf{cube, level.values[static_cast<std::size_t>(at - level.codes.begin())]};
    }
  }
  return {};
}

std::vector<Leaf> leaves_in_post_order(const LinearOctree& octree) {
  std::vector<Leaf> leaves;
  leaves.reserve(static_cast<std::size_t>(leaf_count(octree)));
  for (int k = 0; k <= octree.root_level; ++k) {
    const LinearOctree::Level& level = octree.levels[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < level.codes.size(); ++i) {
      leaves.push_back({{k, level.codes[i]}, level.values[i]});
    }
  }
  std::sort(leaves.begin(), leaves.end(),
            [](const Leaf& a, const Leaf& b) { return is_before_in_post_order(a.cube, b.cube); });
  return leaves;
}

}  // namespace octavo
