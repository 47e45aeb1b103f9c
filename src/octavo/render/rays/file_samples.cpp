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
  range_ = range_of(reader_->range(), true);
  bricks_ = BrickRanges(size_, brick_side_at(levels, level), [&](const Index3& brick) {
    const BrickEntry entry = reader_->brick(Levels::tier_of(level), brick);
    return range_of(entry.range, entry.is_uniform());
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

}  // namespace octavo
