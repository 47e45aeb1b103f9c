#include "octavo/codec/label/label_grid.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>

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

/// The children of parents `from` .. `end` along x, all axes halved.
void expand_rows(const LabelGrid& parents, const Index3& from, std::int64_t end,
                 LabelGrid& children) {
  const Index3 first{2 * from.x, 2 * from.y, 2 * from.z};
  const std::int64_t count = std::min(2 * end, children.size().x) - first.x;
  LabelCell* const row = children.at(first);
  expand_row(parents.at(from), count, true, row);
  const bool has_y = first.y + 1 < children.size().y;
  const bool has_z = first.z + 1 < children.size().z;
  LabelCell* const behind = row + children.plane_stride();
  if (has_y) std::copy_n(row, count, row + children.row_stride());
  if (has_z) std::copy_n(row, count, behind);
  if (has_y && has_z) std::copy_n(row, count, behind + children.row_stride());
}

}  // namespace

void LabelGrid::reset(const Size3& size) {
  size_ = size;
  row_ = size.x + 2 * kBorder;
  plane_ = row_ * (size.y + 2 * kBorder);
  // One plane and one row more: SIMD also reads around children that do not exist.
  const auto count = static_cast<std::size_t>(plane_ * (size.z + 2 * kBorder + 1) + row_);
  std::size_t unknown = count;  // of the first cells: whether a border stands there
  if (size == largest_) {
    unknown = std::exchange(used_count_, 0);
  } else if (count >= largest_count_) {
    cells_.resize(count);
    largest_ = size;
    largest_count_ = count;
    used_count_ = 0;
  } else {
    used_count_ = std::max(used_count_, count);
  }

  // Between two rows lie the end of one and the start of the next; more between two planes.
  LabelCell* border = cells_.data();
  const LabelCell* const end = cells_.data() + unknown;
  for (std::int64_t z = 0; z < size.z; ++z) {
    if (border >= end) return;
    std::fill(border, at({0, 0, z}), LabelCell{kOutside});
    for (std::int64_t y = 0; y < size.y; ++y) {
      border = at({size.x, y, z});
      std::fill_n(border, 2 * kBorder, LabelCell{kOutside});
    }
  }
  if (border < end) std::fill(border, cells_.data() + count, LabelCell{kOutside});
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

void expand_near_mixed(const LabelGrid& parents, const MixedRows& mixed, const Size3& size,
                       LabelGrid& children) {
  children.reset(size);
  // Two steps of children are one of parents: rows together with those beside them along y, and a
  // plane of nothing on either side.
  const Size3& coarse = parents.size();
  const auto rows = static_cast<std::size_t>(coarse.y);
  MixedRows beside(rows * static_cast<std::size_t>(coarse.z + 2));
  for (std::size_t first = 0; first < mixed.size(); first += rows) {
    for (std::size_t y = 0; y < rows; ++y) {
      const std::uint64_t* const row = mixed.data() + first + y;
      beside[rows + first + y] =
          row[0] | (y > 0 ? row[-1] : 0) | (y + 1 < rows ? row[1] : 0);
    }
  }

  std::size_t row = 0;
  for (std::int64_t z = 0; z < coarse.z; ++z) {
    for (std::int64_t y = 0; y < coarse.y; ++y, ++row) {
      const std::uint64_t near = beside[row] | beside[row + rows] | beside[row + 2 * rows];
      if (near == 0) continue;
      const std::int64_t lo = std::max(std::countr_zero(near) - 1, 0);
      const auto hi = std::min(static_cast<std::int64_t>(std::bit_width(near)) + 1, coarse.x);
      expand_rows(parents, {lo, y, z}, hi, children);
    }
  }
}

}  // namespace octavo
