// Words of labels against arrays of them: pyramids made of words, and words of what was decoded.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/codec/label/label_pyramid.h"
#include "octavo/codec/label/label_walk.h"
#include "octavo/octree/label_words.h"

namespace octavo {

/// The pyramid over the brick of these words. Where the first two halvings are those of all axes,
/// level 0 stays in the words, which outlive the pyramid, and samples of level 1 below a uniform
/// one are left as they are: nothing looks at them.
/// Throws   Error{invalid_argument} for a shape whose levels do not end in a single sample
/// Memory   that of `pyramid`, which is reused
void build_label_pyramid(const BrickShape& shape, const LabelWords& words, LabelPyramid& pyramid);

/// Brings level 0 out of the words into the levels.
void complete_voxels(const LabelWords& words, LabelPyramid& pyramid);

/// The words of level 0 of a brick, as a decoder has left it.
void words_of_cells(const BrickShape& shape, const LabelWork& work, LabelWords& words);

/// The words of voxels, dense [z][y][x].
void words_of_voxels(const Size3& size, const std::vector<std::int64_t>& voxels,
                     LabelWords& words);

}  // namespace octavo
