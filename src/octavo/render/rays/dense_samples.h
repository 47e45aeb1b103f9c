// Samples of a grid in memory, for rays.
#pragma once

#include "octavo/render/rays/brick_ranges.h"
#include "octavo/render/rays/sample_source.h"

namespace octavo {

/// Looks at an array [z][y][x] that outlives it. Knows the bounds of its bricks.
class DenseSamples final : public SampleSource {
 public:
  /// brick_side  of the bricks whose bounds it knows
  DenseSamples(const void* samples, VoxelType type, const Size3& size, int brick_side = 64);

  Size3 size() const override { return size_; }
  VoxelType type() const override { return type_; }
  SampleRange range() const override { return range_; }
  SampleRange range(const Box& box) const override { return bricks_.within(box, range_); }
  void read(const Box& box, void* out) const override;

 private:
  const void* samples_;
  VoxelType type_;
  Size3 size_;
  SampleRange range_;
  BrickRanges bricks_;
};

}  // namespace octavo
