// The samples of one level while it is coded: what is known of each, with a border of two all
// around.
//
// A cell is 4 * slot + state. A slot is the number of a label in the order in which the brick's
// labels are first coded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "octavo/core/levels.h"

namespace octavo {

enum LabelState : std::uint16_t {
  kOutside = 0,  ///< beyond the border of the brick; the cell is 0
  kParent = 1,   ///< not coded yet: the label of its parent stands in
  kMixed = 2,    ///< the label is right, some voxel below has another
  kUniform = 3,  ///< the label is right and that of all voxels below
};

using LabelCell = std::uint16_t;
/// Slots are smaller than this; a brick of more labels is stored, not coded.
inline constexpr std::size_t kMaxLabelSlots = std::size_t{1} << 14;

constexpr LabelCell label_cell(std::uint32_t slot, LabelState state) {
  return static_cast<LabelCell>(slot << 2 | state);
}
constexpr std::uint32_t slot_of(LabelCell cell) { return static_cast<std::uint32_t>(cell >> 2); }
constexpr LabelState state_of(LabelCell cell) { return static_cast<LabelState>(cell & 3); }

class LabelGrid {
 public:
  static constexpr std::int64_t kBorder = 2;

  /// Makes it a grid of `size`, kOutside all around; what its cells are is not known. Of the border
  /// that the largest grid so far had, only what others have used since is made anew.
  void reset(const Size3& size);

  const Size3& size() const { return size_; }
  std::ptrdiff_t row_stride() const { return row_; }
  std::ptrdiff_t plane_stride() const { return plane_; }
  LabelCell* at(const Index3& p) {
    return cells_.data() + (p.z + kBorder) * plane_ + (p.y + kBorder) * row_ + p.x + kBorder;
  }
  const LabelCell* at(const Index3& p) const { return const_cast<LabelGrid*>(this)->at(p); }

 private:
  Size3 size_;
  std::ptrdiff_t row_ = 0;
  std::ptrdiff_t plane_ = 0;
  std::vector<LabelCell> cells_;
  Size3 largest_;
  std::size_t largest_count_ = 0;  ///< of its cells
  std::size_t used_count_ = 0;     ///< of the first ones, by grids since
};

/// Which cells of a grid are mixed: bit x of row size.y * z + y.
using MixedRows = std::vector<std::uint64_t>;

/// Makes `children` the level of `size` below `parents`: each cell has its parent's label; it is
/// kUniform where its parent is, kParent elsewhere.
void expand(const LabelGrid& parents, const Size3& size, HalvingMask mask, LabelGrid& children);

/// As expand where all axes are halved, but leaves out cells more than two steps away from those
/// below a mixed parent: a traversal does not look at them.
void expand_near_mixed(const LabelGrid& parents, const MixedRows& mixed, const Size3& size,
                       LabelGrid& children);

}  // namespace octavo
