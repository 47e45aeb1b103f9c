#include "octavo/codec/label_grid.h"

#include <algorithm>

namespace octavo {

namespace {

/// What a child knows before it is visited: a mixed parent's label is only a stand-in.
LabelCell inherited(LabelCell parent) {
  return state_of(parent) == kUniform ? parent : label_cell(slot_of(parent), kParent);
}

void expand_row(const LabelCell* parents, std::int64_t size, bool is_halved, LabelCell* children) {
  if (!is_halved) {
    for (std::int64_t x = 0; x < size; ++x) children[x] = inherited(parents[x]);
    return;
  }
  for (std::int64_t x = 0; x + 1 < size; x += 2) {
    children[x] = children[x + 1] = inherited(parents[x >> 1]);
  }
  if (size & 1) children[size - 1] = inherited(parents[size >> 1]);
}

}  // namespace

LabelGrid expanded(const LabelGrid& parents, const Size3& size, HalvingMask mask) {
  LabelGrid children(size);
  const int half_y = mask >> 1 & 1;
  const int half_z = mask >> 2 & 1;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      LabelCell* row = children.at({0, y, z});
      if (half_y != 0 && (y & 1) != 0) {
        std::copy_n(children.at({0, y - 1, z}), size.x, row);
      } else if (half_z != 0 && (z & 1) != 0) {
        std::copy_n(children.at({0, y, z - 1}), size.x, row);
      } else {
        expand_row(parents.at({0, y >> half_y, z >> half_z}), size.x, (mask & 1) != 0, row);
      }
    }
  }
  return children;
}

}  // namespace octavo
