// The labels of a part of a label map, with those around it.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/octree/o_code.h"

namespace octavo {

/// Labels of a box with one voxel around it; what is outside the volume has a label of no voxel.
/// Memory  8 bytes per voxel
class LabelBlock {
 public:
  static constexpr std::int64_t kOutside = std::numeric_limits<std::int64_t>::min();

  /// Throws what the reader throws.
  LabelBlock(const FileReader& reader, const Box& box);

  /// The row at (y, z) of the box, from x = 0; one voxel more on every side may be looked at.
  std::int64_t* row(std::int64_t y, std::int64_t z) {
    return labels_.data() + (z + 1) * plane_ + (y + 1) * row_ + 1;
  }

  /// How far the voxel beside another is, in `labels`.
  std::int64_t step_to(const Direction& direction) const {
    return direction.z * plane_ + direction.y * row_ + direction.x;
  }

  /// How many voxels lo <= x < hi of a row, all of one label, have a face neighbor of another.
  std::uint64_t surface_of(std::int64_t lo, std::int64_t hi, std::int64_t y, std::int64_t z);

 private:
  std::int64_t row_ = 0;
  std::int64_t plane_ = 0;
  std::vector<std::int64_t> labels_;
};

}  // namespace octavo
