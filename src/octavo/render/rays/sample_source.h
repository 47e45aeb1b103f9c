// Where the bricks that rays cross come from: the samples of one grid.
#pragma once

#include <cstdint>

#include "octavo/core/box.h"
#include "octavo/core/voxel_type.h"

namespace octavo {

/// Values from lowest to highest. Of floats those that are finite.
struct SampleRange {
  double lowest = 0;
  double highest = 0;
};

/// Reading from it is thread-safe.
class SampleSource {
 public:
  virtual ~SampleSource() = default;

  virtual Size3 size() const = 0;
  virtual VoxelType type() const = 0;
  /// Bounds of all samples.
  virtual SampleRange range() const = 0;
  /// Bounds of those in a box, as far as they are known without reading any.
  virtual SampleRange range(const Box& box) const = 0;
  /// Reads a box that lies inside, dense [z][y][x], samples of type().
  virtual void read(const Box& box, void* out) const = 0;
};

}  // namespace octavo
