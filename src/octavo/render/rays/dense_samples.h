// Samples of a grid in memory, for rays.
#pragma once

#include <vector>

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
  SampleRange range(const Box& box) const override;
  void read(const Box& box, void* out) const override;

 private:
  const void* samples_;
  VoxelType type_;
  Size3 size_;
  Size3 side_;
  Size3 grid_;
  SampleRange range_;
  std::vector<SampleRange> bricks_;
};

}  // namespace octavo
