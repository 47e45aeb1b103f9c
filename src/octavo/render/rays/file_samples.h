// Samples of one level of a file, for rays.
#pragma once

#include <memory>

#include "octavo/file/reader.h"
#include "octavo/render/rays/brick_ranges.h"
#include "octavo/render/rays/sample_source.h"

namespace octavo {

/// Bounds are those of the index, so that nothing is decoded where they say enough.
class FileSamples final : public SampleSource {
 public:
  /// Throws  Error{invalid_argument} for a level that is not there
  /// Memory  16 bytes a brick of the level
  FileSamples(std::shared_ptr<const FileReader> reader, int level);

  Size3 size() const override { return size_; }
  VoxelType type() const override { return reader_->description().type; }
  SampleRange range() const override { return range_; }
  SampleRange range(const Box& box) const override { return bricks_.within(box, range_); }
  /// Throws what the reader throws
  void read(const Box& box, void* out) const override { reader_->read(box, level_, out); }

 private:
  SampleRange range_of(const ValueRange& ends, bool is_uniform) const;

  std::shared_ptr<const FileReader> reader_;
  int level_;
  Size3 size_;
  SampleRange range_;
  BrickRanges bricks_;
};

}  // namespace octavo
