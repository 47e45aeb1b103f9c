#include "octavo/render/rays/file_samples.h"

#include <algorithm>
#include <string>
#include <utility>

#include "octavo/core/error.h"

namespace octavo {

FileSamples::FileSamples(std::shared_ptr<const FileReader> reader, int level)
    : reader_(std::move(reader)), level_(level) {
  const Levels& levels = reader_->levels();
  if (level < 0 || level >= levels.count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  size_ = levels.size(level);
  side_ = brick_side_at(levels, level);
  for (int axis = 0; axis < 3; ++axis) {
    grid_[axis] = (size_[axis] + side_[axis] - 1) / side_[axis];
  }
  range_ = range_of(reader_->range(), true);
  bricks_.reserve(static_cast<std::size_t>(grid_.voxel_count()));
  visit_cells(box_of(size_), side_, [&](const Index3& brick) {
    const BrickEntry entry = reader_->brick(Levels::tier_of(level), brick);
    bricks_.push_back(range_of(entry.range, entry.is_uniform()));
    return true;
  });
}

SampleRange FileSamples::range_of(const ValueRange& ends, bool is_uniform) const {
  const VolumeDescription& d = reader_->description();
  const auto [lowest, highest] =
      std::minmax({d.voxel_of(d.code_near(ends.min)), d.voxel_of(d.code_near(ends.max))});
  SampleRange range{lowest, highest};
  // Of floats a brick may hold what is not finite besides: that counts as the lowest or highest.
  if (d.codec_type() == VoxelType::float32 && !is_uniform) range = range_;
  return range;
}

SampleRange FileSamples::range(const Box& box) const {
  SampleRange range = range_;
  bool is_first = true;
  visit_cells(box, side_, [&](const Index3& brick) {
    const std::int64_t number = (brick.z * grid_.y + brick.y) * grid_.x + brick.x;
    const SampleRange& one = bricks_[static_cast<std::size_t>(number)];
    range = is_first ? one
                     : SampleRange{std::min(range.lowest, one.lowest),
                                   std::max(range.highest, one.highest)};
    is_first = false;
    return true;
  });
  return range;
}

}  // namespace octavo
