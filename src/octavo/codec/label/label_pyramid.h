// The most frequent labels of a brick, level by level.
//
//      level 0          level 1       root
//      2 2 | 5 5
//      2 7 | 5 5   ->   2  5     ->   7      a sample is the most frequent label of its octant,
//      ----+----        7  7                 each child counted as often as voxels lie below it; of
//      7 7 | 7 7                             labels equally frequent, the smallest
//      7 7 | 7 7
//
// Labels are kept as ranks among the distinct labels of the brick, so that ranks compare as labels
// do.
//
// Invariants
// - labels is sorted without repeats; every rank is below its size.
// - levels holds one more level than the shape: the root, a single sample that stands for the brick
// at the
//   first level of the next tier.
// - is_uniform says that all voxels below a sample have its label; at level 0 it always holds. A
// sample
//   that is not uniform has, somewhere below it, a voxel with another label.
//
// Source: thesis 2.4 (condensation), with a vote where siblings differ.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/octree/label_words.h"

namespace octavo {

struct LabelPyramid {
  struct Level {
    Size3 size;
    std::vector<std::uint32_t> rank;       ///< [z][y][x]
    std::vector<std::uint8_t> is_uniform;  ///< [z][y][x], 0 or 1
  };

  std::vector<std::int64_t> labels;
  std::vector<Level> levels;
  const LabelWords* words = nullptr;  ///< where given, level 0 is there and not in `levels`

  bool is_uniform() const { return labels.size() == 1; }
  const Level& root() const { return levels.back(); }
};

/// Makes `coarse` the level above `fine`, which is that of in-brick level `level`.
void condense_labels(const BrickShape& shape, int level, const LabelPyramid::Level& fine,
                     LabelPyramid::Level& coarse);

/// The pyramid over one brick.
/// Throws   Error{invalid_argument} for float32 voxels, a view whose size is not that of the shape,
///          or a shape whose levels do not end in a single sample
/// Memory   about 9 bytes per voxel
LabelPyramid build_label_pyramid(const BrickShape& shape, const BrickView& brick);

}  // namespace octavo
