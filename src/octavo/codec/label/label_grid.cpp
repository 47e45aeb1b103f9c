#include "octavo/codec/label/label_grid.h"

#include <algorithm>
#include <cstring>

namespace octavo {

namespace {

/// What a child knows before it is visited: a mixed parent's label is only a stand-in.
LabelCell inherited(LabelCell parent) {
  const auto stand_in = static_cast<LabelCell>((parent & ~3) | kParent);
  return state_of(parent) == kUniform ? parent : stand_in;
}

void expand_row(const LabelCell* parents, std::int64_t size, bool is_halved, LabelCell* children) {
  if (!is_halved) {
    for (std::int64_t x = 0; x < size; ++x) children[x] = inherited(parents[x]);
    return;
  }
  for (std::int64_t x = 0; x < size / 2; ++x) {
    const std::uint32_t twice = inherited(parents[x]) * 0x10001u;
    std::memcpy(children + 2 * x, &twice, sizeof twice);
  }
  if (size & 1) children[size - 1] = inherited(parents[size >> 1]);
}

}  // namespace

void LabelGrid::reset(const Size3& size) {
  size_ = size;
  row_ = size.x + 2 * kBorder;
  plane_ = row_ * (size.y + 2 * kBorder);
  // One plane and one row more: SIMD also reads around children that do not exist.
  const auto count = static_cast<std::size_t>(plane_ * (size.z + 2 * kBorder + 1) + row_);
  if (cells_.size() < count) cells_.resize(count);

  // Between two rows lie the end of one and the start of the next; more between two planes.
  LabelCell* border = cells_.data();
  for (std::int64_t z = 0; z < size.z; ++z) {
    std::fill(border, at({0, 0, z}), LabelCell{kOutside});
    for (std::int64_t y = 0; y < size.y; ++y) {
      border = at({size.x, y, z});
      std::fill_n(border, 2 * kBorder, LabelCell{kOutside});
    }
  }
  std::fill(border, cells_.data() + count, LabelCell{kOutside});
}

void expand(const LabelGrid& parents, const Size3& size, HalvingMask mask, LabelGrid& children) {
  children.reset(size);
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
}

}  // namespace octavo
