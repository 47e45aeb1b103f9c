// Between which values the samples of a grid lie, brick by brick.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "octavo/render/rays/sample_source.h"

namespace octavo {

/// Of nothing: joined with a range it is that range.
inline constexpr SampleRange kNoSamples = {std::numeric_limits<double>::infinity(),
                                           -std::numeric_limits<double>::infinity()};

inline SampleRange joined_range(const SampleRange& a, const SampleRange& b) {
  return {std::min(a.lowest, b.lowest), std::max(a.highest, b.highest)};
}

class BrickRanges {
 public:
  BrickRanges() = default;
  /// range_of  of the place of a brick; kNoSamples where it has no finite sample
  template <class RangeOf>
  BrickRanges(const Size3& size, const Size3& side, RangeOf&& range_of) : side_(side) {
    for (int axis = 0; axis < 3; ++axis) {
      grid_[axis] = (size[axis] + side[axis] - 1) / side[axis];
    }
    ranges_.reserve(static_cast<std::size_t>(grid_.voxel_count()));
    visit_cells(box_of(size), side, [&](const Index3& brick) {
      ranges_.push_back(range_of(brick));
      return true;
    });
  }

  /// Of the bricks that a box meets together; `otherwise` where they have none.
  SampleRange within(const Box& box, const SampleRange& otherwise) const {
    SampleRange range = kNoSamples;
    visit_cells(box, side_, [&](const Index3& brick) {
      const std::int64_t number = (brick.z * grid_.y + brick.y) * grid_.x + brick.x;
      range = joined_range(range, ranges_[static_cast<std::size_t>(number)]);
      return true;
    });
    return range.lowest > range.highest ? otherwise : range;
  }

 private:
  Size3 side_;
  Size3 grid_;
  std::vector<SampleRange> ranges_;
};

}  // namespace octavo
