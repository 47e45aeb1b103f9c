// The masks of the labels of a map.
//
// Words are divided among their labels as words, and a uniform child is a full child of one of
// them: no voxel is looked at. Cubes of 64^3 are taken on all threads and give a sub-tree for every
// label in them, so that memory is that of the trees, however many labels there are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/octree/label_tree.h"
#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo {

struct LabelMask {
  std::int64_t label = 0;
  MaskTree tree;
};

inline constexpr std::size_t kMostLabelMasks = 65536;

/// The voxels that have one of `labels`, of which 0 is none. Uses the threads of the calling task
/// arena. A word whose palette has none of the labels costs one look.
MaskTree mask_of(const LabelTree& tree, std::span<const std::int64_t> labels);

/// The masks of all labels but 0, in ascending order. Uses the threads of the calling task arena.
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the masks grow beyond it
/// Throws  Error{limit_exceeded} above kMostLabelMasks labels
std::vector<LabelMask> masks_of(const LabelTree& tree, std::uint64_t max_bytes = 0);

/// The masks of the labels of a level that lie in one of `windows`, all but 0, in ascending order.
/// At level 0 bricks of one label are not decoded. Uses the threads of the calling task arena.
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the masks grow beyond it
/// Throws what the reader throws, Error{cancelled}; Error{invalid_argument} for a level that is not
///        there and for a grey volume; Error{limit_exceeded} above kMostLabelMasks labels
std::vector<LabelMask> masks_of_labels(const FileReader& reader, int level,
                                       std::span<const ValueWindow> windows, Progress& progress,
                                       std::uint64_t max_bytes = 0);

}  // namespace octavo
