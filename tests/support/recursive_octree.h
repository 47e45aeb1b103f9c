// The recursive procedure of the thesis (Fig. 2.2): top down, sequential, over the whole volume. An
// oracle.
#pragma once

#include <algorithm>
#include <span>

#include "octavo/octree/condense.h"

namespace octavo::testing {

/// A volume of 64-bit voxels, [z][y][x].
struct DenseVolume {
  Size3 size;
  std::vector<std::int64_t> voxels;
};

inline void divide(const DenseVolume& volume, const CondenseOptions& options, const OCode& cube,
                   LinearOctree& octree) {
  const Box all = box_of(volume.size);
  const Box box = box_of(cube);
  if (intersection(all, box).is_empty()) return;
  std::vector<std::int64_t> values;
  if (all.contains(box)) {
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x)
          values.push_back(
              volume.voxels[static_cast<std::size_t>((z * volume.size.y + y) * volume.size.x + x)]);
    const auto background =
        std::count(values.begin(), values.end(), options.background.value_or(0));
    const bool is_labels = options.background.has_value();
    if (is_labels && background == static_cast<std::ptrdiff_t>(values.size())) return;
    const auto [min, max] = std::minmax_element(values.begin(), values.end());
    if (*max - *min <= options.flat && (!is_labels || background == 0)) {
      std::int64_t twice_sum = 0;
      for (const std::int64_t v : values) twice_sum += 2 * (v - *min);
      const auto count = static_cast<std::int64_t>(values.size());
      auto& level = octree.levels[static_cast<std::size_t>(cube.level)];
      level.codes.push_back(cube.code);
      level.values.push_back(*min + (twice_sum + count) / (2 * count));
      return;
    }
  }
  for (const OCode& child : children_of(cube)) divide(volume, options, child, octree);
}

/// The octree of `volume`, by dividing the universe cube until every part is homogeneous.
inline LinearOctree recursive_octree(const DenseVolume& volume, const CondenseOptions& options) {
  LinearOctree octree = empty_octree(universe_level(volume.size));
  divide(volume, options, {octree.root_level, 0}, octree);
  return octree;
}

}  // namespace octavo::testing
