#include "octavo/ops/mask/fill_holes.h"

#include <utility>
#include <vector>

#include "octavo/ops/mask/components.h"
#include "octavo/ops/mask/set_operations.h"

namespace octavo {

namespace {

bool is_at_border(const Box& box, const Size3& size) {
  for (int axis = 0; axis < 3; ++axis) {
    if (box.lo[axis] == 0 || box.hi[axis] == size[axis]) return true;
  }
  return false;
}

}  // namespace

FilledHoles fill_holes(const MaskTree& mask, Connectivity object, std::uint64_t max_voxels,
                       std::uint64_t max_bytes) {
  const MaskTree background = complement(mask);
  const Components parts(background, dual_of(object), max_bytes);
  FilledHoles filled;
  std::vector<bool> is_filled;
  is_filled.reserve(parts.components().size());
  for (const Component& part : parts.components()) {
    const bool is_hole = !is_at_border(part.box, mask.size());
    const bool is_small = part.voxel_count <= max_voxels;
    is_filled.push_back(is_hole && is_small);
    if (is_hole && !is_small) ++filled.kept_count;
    if (!is_filled.back()) continue;
    ++filled.hole_count;
    filled.voxel_count += part.voxel_count;
  }
  filled.mask = combine(mask, parts.select(is_filled), SetOperation::unite);
  return filled;
}

}  // namespace octavo
